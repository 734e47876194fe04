// A world on the floor: z up, the floor at zero, its origin at the centre of
// where people walked. Estimated from their feet.
#ifndef KINEGRAPH_SOLVERS_SESSION_GROUND_H_
#define KINEGRAPH_SOLVERS_SESSION_GROUND_H_

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "core/data/detection.h"
#include "core/data/pose.h"
#include "core/geometry/camera.h"
#include "core/io/configuration/refinement_record.h"
#include "solvers/session/options.h"
#include "solvers/session/scene.h"

namespace kinegraph {

// p_new = R p_old + t. The new x axis is as near to the old one as an upright
// world permits.
struct Ground {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::Zero();
  double tilt_deg = 0.0;   // between the old z axis and up
  double spread_m = 0.0;   // rms of the resting feet about the floor
  int64_t foot_count = 0;  // number of feet used
};

// nullopt if too few people stand or walk. Assumes that heads are above feet on
// average.
std::optional<Ground> GroundOf(const TrackHeader& header,
                               const std::vector<TrackFrame>& frames);

// The cameras in the new world.
CameraRig OnGround(const CameraRig& cameras, const Ground& ground);

// Transforms a record's centres to the new world.
void TurnRecord(const Ground& ground, RefinementRecord* record);

// Options for tracking once with the cameras as they are: the paper's estimator
// and one pass.
RunOptions QuickOptions(RunOptions options);

// Tracks the recording once, with QuickOptions, for GroundOf. Throws as
// PrepareScene.
std::optional<Ground> FindGround(const RunOptions& options,
                                 const RunRequest& request,
                                 const DetectionSequence& detections);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SESSION_GROUND_H_
