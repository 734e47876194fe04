// The files of --images, which are shown behind the panel of each view: images,
// one file per frame, or a video. They are linked from the page or embedded.
#ifndef KINEGRAPH_APPS_REPORT_VIEW_IMAGES_H_
#define KINEGRAPH_APPS_REPORT_VIEW_IMAGES_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "apps/report/page_data.h"

namespace kinegraph {

// One entry per view, in the order of the detections' views.
struct ViewImages {
  std::vector<std::string> patterns;  // paths of images; empty: none
  struct Video {
    std::string path;
    PageVideo shown;  // `source` and `bytes` are not set yet
  };
  std::vector<std::optional<Video>> videos;

  bool has_patterns() const;
};

// Reads the value of --images, "VIEW=PATTERN;VIEW=VIDEO;VIEW=VIDEO@FIRST",
// where FIRST (default 0) is the frame number of the video's first image. If
// the container of a video does not list its images, the frame rate of the
// first result is assumed, or kFallbackRateHz. Throws InputError for an invalid
// entry, for an unknown or repeated view, or if a pattern or video lacks the
// first frame of the first result.
ViewImages ReadViewImages(const std::string& images, const PageInput& input);

// Number of frames of the first result outside the video.
size_t FramesWithout(const ViewImages::Video& video, const PageInput& input);

// If `max_bytes` is 0, links the videos from the page at `page_path`; otherwise
// embeds them. Returns the bytes of their Base64 text. If these would exceed
// `max_bytes`, throws an InputError that explains how to reduce their size.
size_t AddVideos(const ViewImages& images, const std::string& page_path,
                 size_t max_bytes, PageInput* input);

// "cam1/000042.jpg" for "cam1/%06d.jpg". Throws InputError unless the pattern
// has exactly one number such as %d or %06d.
std::string PicturePath(const std::string& pattern, int64_t frame);

// Embedded images.
struct EmbeddedPictures {
  int stride = 1;  // 2: images of every second frame
  size_t count = 0;
};

// Embeds the images of `patterns` (one per camera, empty: none) for the frames
// of the first result into `input`, JPEG and PNG unchanged; as many frames as
// fit into `max_bytes` of Base64 text, evenly spaced. After each embedded
// frame, calls `step` with the number of frames done so far, which includes the
// frames skipped before the next embedded one. Throws InputError for a file
// that is neither JPEG nor PNG or is larger than 200 MiB.
EmbeddedPictures EmbedPictures(const std::vector<std::string>& patterns,
                               size_t max_bytes,
                               const std::function<void(int64_t frames)>& step,
                               PageInput* input);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_REPORT_VIEW_IMAGES_H_
