// Detections: 2D poses in the views of one frame.
#ifndef KINEGRAPH_CORE_DATA_DETECTION_H_
#define KINEGRAPH_CORE_DATA_DETECTION_H_

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/time.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph {

// One joint in one image. When `found` is false the other fields are
// meaningless: the joint is not a measurement and is ignored everywhere.
struct Keypoint {
  Eigen::Vector2d px = Eigen::Vector2d::Zero();  // raw (distorted) pixels
  double confidence = 0.0;  // as reported by the detector; may exceed 1
  bool found = false;
};

// One person in one image, as the detector grouped the joints.
struct Detection {
  std::vector<Keypoint> joints;  // in the order of the sequence's skeleton
  int index_in_file = 0;         // counts from zero within its view and frame
};

// All people detected by one camera at one time.
struct ViewDetections {
  // On the clock of DetectionFrame::time, and equal to it unless the view has
  // its own times.
  TimeNs capture_time = 0;
  std::vector<Detection> detections;
};

// All views of one frame, in the order of the sequence's view names.
struct DetectionFrame {
  int64_t frame = 0;
  TimeNs time = 0;
  std::vector<ViewDetections> views;
};

// Properties of a whole recording.
struct DetectionHeader {
  Skeleton skeleton;
  std::vector<std::string> view_names;
  double frame_rate_hz = 0.0;  // 0: unknown
};

struct DetectionSequence {
  DetectionHeader header;
  std::vector<DetectionFrame> frames;  // ascending
};

// nullptr if there is no such frame.
const DetectionFrame* FindDetectionFrame(const DetectionSequence& detections,
                                         int64_t frame);

// Number of found joints.
int CountFound(const Detection& detection);

// `detection` in another skeleton; `map` as returned by MapByName(from, to).
// Joints that the source lacks are not found.
Detection Convert(const Detection& detection, const std::vector<int>& map);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_DATA_DETECTION_H_
