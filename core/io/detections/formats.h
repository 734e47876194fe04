// What the readers of detections share. Only core/io/detection*.cc includes
// this header.
#ifndef KINEGRAPH_CORE_IO_DETECTIONS_FORMATS_H_
#define KINEGRAPH_CORE_IO_DETECTIONS_FORMATS_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/io/detections/source.h"

namespace kinegraph {

// The options that a format's `open` is given are checked; `skeleton` is set
// when either the value or a name was given.

// What a file stores as x, y, confidence, in the file's own pixels. NaN, also
// as confidence, is no measurement. Every reader asks here which points are
// missing.
Keypoint MakeKeypoint(double x_px, double y_px, double confidence,
                      ZeroConfidence zero_confidence);

// The view files of a folder in natural order (without truth.json), or the one
// file that `path` is: pairs of view name (the file name without its extension)
// and path. Throws InputError when there is none.
std::vector<std::pair<std::string, std::string>> ListViewFiles(
    const std::string& path, const std::string& extension = ".json");

// What the options and the names of view files say of a recording.
DetectionHeader HeaderOfViews(
    const std::vector<std::pair<std::string, std::string>>& files,
    const DetectionReadOptions& options);

// Opens a format with a file a view. A Reader is made from header and options,
// reads file after file and finishes.
template <typename Reader>
std::unique_ptr<DetectionSource> OpenViewFiles(
    const std::string& path, const DetectionReadOptions& options,
    const std::string& extension) {
  const auto files = ListViewFiles(path, extension);
  Reader reader(HeaderOfViews(files, options), options);
  for (size_t v = 0; v < files.size(); ++v) reader.ReadFile(files[v].second, v);
  return reader.Finish();
}

// Layouts of detectors with so many joints, the commonest first. Throws
// InputError without a file, naming `key`, when there is none.
std::vector<const Skeleton*> DetectorSkeletons(size_t joint_count,
                                               const std::string& key);

// Whether a reader that counts joints takes them for this layout.
bool IsToldByJointCount(const Skeleton& skeleton);

// Collects detections of formats whose files hold a whole recording, in any
// order of frames, and hands them out frame by frame.
class DetectionCollector {
 public:
  explicit DetectionCollector(DetectionHeader header)
      : header_(std::move(header)) {}
  const DetectionHeader& header() const { return header_; }
  // For files that tell it by their first person.
  void set_skeleton(const Skeleton& skeleton) { header_.skeleton = skeleton; }
  // For files that state it, one after the other (SkeletonOfLabels). The first
  // decides, where the options do not. Throws InputError without a file when
  // the next one has other labels, or not as many as the options' skeleton.
  void SettleSkeleton(const std::vector<std::string>& labels,
                      const std::vector<Bone>& bones = {},
                      const std::string& name = "");
  // The place of a new detection, its index_in_file set.
  Detection* Add(int64_t frame, size_t view_idx);
  // Makes sure that the frame is there even if nobody was seen.
  DetectionFrame* Touch(int64_t frame);
  std::unique_ptr<DetectionSource> Finish();

 private:
  DetectionHeader header_;
  std::vector<std::string> labels_;  // of the first file that states them
  std::map<int64_t, DetectionFrame> frames_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_DETECTIONS_FORMATS_H_
