// What the tables of DeepLabCut share, CSV and HDF5: a column a coordinate,
// named by individual, bodypart and coord; a file a view; and several detectors
// of the same views, fused. For core/io alone.
#ifndef KINEGRAPH_CORE_IO_DETECTIONS_DEEPLABCUT_RECORDING_H_
#define KINEGRAPH_CORE_IO_DETECTIONS_DEEPLABCUT_RECORDING_H_

#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/io/detections/csv_keypoints.h"
#include "core/io/detections/formats.h"

namespace kinegraph {

// Where the joints of each individual stand.
struct DeepLabCutColumns {
  std::vector<std::string> labels;  // bodyparts
  std::vector<std::vector<KeypointColumns>> people;
};

// One name a column; `individuals` may be empty. Columns before `first` are the
// index. Throws InputError without a file.
DeepLabCutColumns FindDeepLabCutColumns(
    const std::vector<std::string>& individuals,
    const std::vector<std::string>& parts,
    const std::vector<std::string>& coords, size_t first);

// The recording as it is read. With several detectors, such as two seeds of one
// network, each joint of a view is the mean of what they say, weighed by
// confidence; its confidence is their mean, 0 for one who does not see it.
// Where they are apart by more than a twentieth of the diagonal of the person's
// box (some 9 cm on an adult, more than noise), the most confident one is taken
// and the others count as not seeing the joint.
class DeepLabCutRecording {
 public:
  DeepLabCutRecording(const DetectionHeader& header, int detectors)
      : detectors_(detectors), collector_(header) {}

  // DetectionCollector's.
  void SettleSkeleton(const std::vector<std::string>& labels) {
    collector_.SettleSkeleton(labels);
  }
  void Touch(int64_t frame) { collector_.Touch(frame); }
  void Add(int64_t frame, size_t view_idx, size_t person,
           std::vector<Keypoint> joints);
  std::unique_ptr<DetectionSource> Finish();

 private:
  struct Place {
    int64_t frame = 0;
    size_t view_idx = 0;
    size_t person = 0;
    bool operator<(const Place& other) const;
  };

  const int detectors_;
  DetectionCollector collector_;
  // What each detector says; with one alone nothing waits here.
  std::map<Place, std::vector<std::vector<Keypoint>>> waiting_;
};

// Opens a folder with a file a view, one such file, or a folder with such a
// folder a detector. `read` adds one file to the recording.
std::unique_ptr<DetectionSource> OpenDeepLabCut(
    const std::string& path, const DetectionReadOptions& options,
    const std::string& extension,
    void (*read)(const std::string& file, size_t view_idx,
                 const DetectionReadOptions& options,
                 DeepLabCutRecording* recording));

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_DETECTIONS_DEEPLABCUT_RECORDING_H_
