// Where a body's mass is.
#ifndef KINEGRAPH_CORE_KINEMATICS_MASS_H_
#define KINEGRAPH_CORE_KINEMATICS_MASS_H_

#include <Eigen/Core>
#include <optional>
#include <utility>
#include <vector>

#include "core/data/pose.h"

namespace kinegraph {

// Weights of the joints whose sum is the centre of mass, by the segments of
// Winter, "Biomechanics and Motor Control of Human Movement" (4th ed., table
// 4.1): trunk with head and neck, upper arms, forearms with hands, thighs,
// shanks with feet. They sum to 1. Empty when the skeleton lacks one of the
// twelve joints.
using MassWeights = std::vector<std::pair<int, double>>;
MassWeights MassWeightsOf(const Skeleton& skeleton);

// [m]; nullopt without weights or when one of the joints is missing.
std::optional<Eigen::Vector3d> CentreOfMass(const MassWeights& weights,
                                            const Pose3d& pose);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_KINEMATICS_MASS_H_
