// A detection prepared for geometry: in the skeleton of the tracks, with its
// joints undistorted once.
#ifndef KINEGRAPH_CORE_DATA_OBSERVATION_H_
#define KINEGRAPH_CORE_DATA_OBSERVATION_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/base/time.h"
#include "core/data/detection.h"
#include "core/geometry/camera.h"

namespace kinegraph {

// The joints filter's verdict on a joint in one view.
enum class FilterVerdict : uint8_t { kUnmeasured, kKept, kRemoved };

struct Observation {
  int view_idx = 0;
  int detection_idx = 0;  // index_in_file of the detection
  TimeNs capture_time = 0;
  // One per joint of the tracks' skeleton. Raw pixels, for comparison with
  // projections and for gates.
  std::vector<Keypoint> joints;
  // Undistorted pixels, one per joint, for rays, epipolar distances and DLT;
  // valid where the joint is found.
  std::vector<Eigen::Vector2d> ideal_px;
  // Computed over the association joints (Skeleton::association_joints), so
  // that feet and hands do not outvote the body.
  int found_count = 0;
  double mean_confidence = 0.0;  // of the found joints; 0 if there are none
};

// Fills `observation` (reusing its memory) from a detection seen by `camera`.
// `map` as returned by MapByName(detections' skeleton, tracks' skeleton);
// found_count and mean_confidence are computed over the joints `counted`. A
// joint whose pixel cannot be undistorted is not found.
void MakeObservation(const Detection& detection, const std::vector<int>& map,
                     const std::vector<int>& counted, const Camera& camera,
                     int view_idx, TimeNs capture_time,
                     Observation* observation);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_DATA_OBSERVATION_H_
