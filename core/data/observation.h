// A detection made ready for geometry: in the skeleton of the tracks, with its
// joints freed of lens distortion once.
#ifndef KINEGRAPH_CORE_DATA_OBSERVATION_H_
#define KINEGRAPH_CORE_DATA_OBSERVATION_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/base/time.h"
#include "core/data/detection.h"
#include "core/geometry/camera.h"

namespace kinegraph {

// What the joints filter said of a joint in one view.
enum class FilterVerdict : uint8_t { kUnmeasured, kKept, kRemoved };

struct Observation {
  int view_idx = 0;
  int detection_idx = 0;  // index_in_file of the detection
  TimeNs capture_time = 0;
  // One a joint of the tracks' skeleton. Raw pixels, for projection and gates.
  std::vector<Keypoint> joints;
  // One a joint, for epipolar distance and DLT; valid where the joint is found.
  std::vector<Eigen::Vector2d> ideal_px;
  // Over the joints that count (Skeleton::association_joints), so that feet and
  // hands do not outvote the body.
  int found_count = 0;
  double mean_confidence = 0.0;  // of the found ones; 0 when there are none
};

// Fills `observation` (reusing its memory) from a detection seen by `camera`.
// `map` as MapByName(detections' skeleton, tracks' skeleton) gives it;
// `counted` are the joints that count. A joint whose pixel the lens cannot
// explain is not found.
void MakeObservation(const Detection& detection, const std::vector<int>& map,
                     const std::vector<int>& counted, const Camera& camera,
                     int view_idx, TimeNs capture_time,
                     Observation* observation);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_DATA_OBSERVATION_H_
