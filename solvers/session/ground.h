// A world that stands on the floor: z up, the floor at zero, the middle of
// where people walked as its origin. Found from their feet.
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

// p_new = R p_old + t. The old x axis stays as near to x as an upright world
// allows.
struct Ground {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::Zero();
  double tilt_deg = 0.0;   // between the old z axis and up
  double spread_m = 0.0;   // of the resting feet about the floor, rms
  int64_t foot_count = 0;  // that it rests on
};

// nullopt when too few people stand or walk. Heads are above feet in the mean.
std::optional<Ground> GroundOf(const TrackHeader& header,
                               const std::vector<TrackFrame>& frames);

// The cameras in the new world.
CameraRig OnGround(const CameraRig& cameras, const Ground& ground);

// A record's centres in the new world.
void TurnRecord(const Ground& ground, RefinementRecord* record);

// To track once as the cameras are: the paper's estimator and one pass.
RunOptions QuickOptions(RunOptions options);

// Tracks the recording once, with QuickOptions, for GroundOf. Throws as
// PrepareScene.
std::optional<Ground> FindGround(const RunOptions& options,
                                 const RunRequest& request,
                                 const DetectionSequence& detections);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SESSION_GROUND_H_
