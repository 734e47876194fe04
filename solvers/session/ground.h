// Estimates a world that stands on the floor from people's feet: z points up,
// the floor is at z = 0, and the origin is in the middle of where people stood.
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

// p_new = R p_old + t. The new x axis is as close to the old one (the old y
// axis, if the old x axis is nearly vertical) as an upright z axis permits.
struct Ground {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::Zero();
  double tilt_deg = 0.0;  // between the old z axis and up
  // RMS distance of resting feet from the floor; each counts at most 0.1 m.
  double spread_m = 0.0;
  int64_t foot_count = 0;  // number of positions of resting foot joints
};

// `frames`: tracks in metres, ascending. nullopt if there are too few positions
// of resting feet, or no pose with both shoulders and both ankles. Assumes that
// shoulders are above ankles on average, unless Stance determines another
// vertical, as for people who lie.
std::optional<Ground> GroundOf(const TrackHeader& header,
                               const std::vector<TrackFrame>& frames);

// The cameras in the new world.
CameraRig OnGround(const CameraRig& cameras, const Ground& ground);

// Rotates the covariance of a record's camera centres into the new world.
void TurnRecord(const Ground& ground, RefinementRecord* record);

// Options for a quick run with the cameras as they are: paper mode, one pass,
// no linking of identities.
RunOptions QuickOptions(RunOptions options);

// GroundOf of the recording, tracked once with QuickOptions. Throws what
// PrepareScene throws.
std::optional<Ground> FindGround(const RunOptions& options,
                                 const RunRequest& request,
                                 const DetectionSequence& detections);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SESSION_GROUND_H_
