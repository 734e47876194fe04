// What --images names: pictures, a file a frame, or a video, behind the panel
// of each view. They are linked from the page or put into it.
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

// One entry a view, in the order of the detections'.
struct ViewImages {
  std::vector<std::string> patterns;  // of pictures; empty: none
  struct Video {
    std::string path;
    PageVideo shown;  // without a source yet
  };
  std::vector<std::optional<Video>> videos;

  bool has_patterns() const;
};

// Reads "VIEW=PATTERN;VIEW=VIDEO;VIEW=VIDEO@FIRST" as --images takes it, where
// FIRST is the number of the video's first picture (0). A video whose container
// does not list its pictures has them at the rate of the first result. Throws
// InputError where a view is unknown, or pattern or video have nothing for the
// first frame.
ViewImages ReadViewImages(const std::string& images, const PageInput& input);

// How many frames of the first result lie outside of the video.
size_t FramesWithout(const ViewImages::Video& video, const PageInput& input);

// Links the videos from the page at `page_path`, or puts their files into it
// where they fit into `max_bytes` of text (0: link). Returns the bytes that
// they take there. Throws InputError that says how to make them smaller.
size_t AddVideos(const ViewImages& images, const std::string& page_path,
                 size_t max_bytes, PageInput* input);

// "cam1/000042.jpg" of "cam1/%06d.jpg". Throws InputError unless the pattern
// has exactly one number such as %d or %06d.
std::string PicturePath(const std::string& pattern, int64_t frame);

// Pictures that are inside of the page.
struct EmbeddedPictures {
  int stride = 1;  // 2: those of every second frame
  size_t count = 0;
  size_t bytes = 0;  // of text in the page
};

// Puts the pictures of `patterns` (one a camera, empty: none) for the frames of
// the first result into `input`, JPEG and PNG as the files are; of as many
// frames as fit into `max_bytes` of text, evenly chosen. `step` is called after
// each frame.
EmbeddedPictures EmbedPictures(const std::vector<std::string>& patterns,
                               size_t max_bytes,
                               const std::function<void()>& step,
                               PageInput* input);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_REPORT_VIEW_IMAGES_H_
