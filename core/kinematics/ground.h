// The upward direction and the height of the floor.
#ifndef KINEGRAPH_CORE_KINEMATICS_GROUND_H_
#define KINEGRAPH_CORE_KINEMATICS_GROUND_H_

#include <Eigen/Core>
#include <optional>
#include <string>

#include "core/data/pose.h"
#include "core/data/stance.h"

namespace kinegraph {

// The unit vector of "x", "-z" and so on; nullopt for "auto". Throws InputError
// naming `what` for any other text.
std::optional<Eigen::Vector3d> ParseUp(const std::string& text,
                                       const std::string& what = "--up");

// Stance::Up, replaced by the world axis within 25 degrees of it if there is
// one; nullopt if unknown.
std::optional<Eigen::Vector3d> UpDirection(const TrackSequence& tracks,
                                           const UpEvidence& known = {});

// Height of the floor along `up` [m]: the 2 % quantile of the poses' lowest
// joints. Ankles are above the floor by a height that is subtracted; other
// joints, such as toes and paws, touch it. 0 without poses.
double FloorHeight(const TrackSequence& tracks, const Eigen::Vector3d& up);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_KINEMATICS_GROUND_H_
