// Observations ("looks") of a skeleton's bones, each from the views of a single
// frame, without a motion prior.
#ifndef KINEGRAPH_SOLVERS_NOISE_BONE_LOOKS_H_
#define KINEGRAPH_SOLVERS_NOISE_BONE_LOOKS_H_

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "core/skeleton/skeleton.h"
#include "solvers/graph/problem.h"

namespace kinegraph {

// Length of a bone in an adult [m], from segment lengths relative to a stature
// of 1.70 m (Drillis and Contini 1966, as in Winter, Biomechanics and Motor
// Control of Human Movement, fig. 4.1); nullopt for other bones and for
// animals, whose joints may have the names of human ones.
std::optional<double> PopulationLength(const Skeleton& skeleton,
                                       const Bone& bone);

// Pairs of joints at constant distance: the skeleton's bones and, for a human,
// the remaining pairs of nose, eyes and ears, which belong to one rigid head.
std::vector<Bone> RigidPairs(const Skeleton& skeleton);

// Whether `bone` connects `a` and `b`, in either order.
bool SameBone(const Bone& bone, int a, int b);

// Position of a joint in one frame from its views alone, without a motion prior
// or bones.
struct BoneEnd {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  // The solver's estimate, on which the frame's own noise has hardly any
  // influence.
  Eigen::Vector3d estimate_m = Eigen::Vector3d::Zero();
  // Covariance of position_m under the modelled noise of the pixels.
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Identity();
  // Sum of squared residuals in sigmas and its degrees of freedom (2 x views -
  // 3), which show how accurate the modelled noise is.
  double square = 0.0;
  int freedom = 0;
  // Number of frames over which the solver averages the joint's position.
  double averaged_frames = 1.0;
};

// One entry per joint; nullopt if fewer than two views have sufficient weight
// (at least `inlier_weight` at the estimate) or if they leave a direction
// undetermined.
// `interval_s`: time between frames.
std::vector<std::optional<BoneEnd>> LocateBoneEnds(const PersonProblem& problem,
                                                   size_t frame_idx,
                                                   double inlier_weight,
                                                   double interval_s);

// One observation of a bone's length.
struct BoneObservation {
  double distance_m = 0.0;
  double square = 0.0;  // of both ends
  int freedom = 0;
  double averaged_frames = 1.0;
  // For the modelled pixel noise: the mean increase of the distance, the
  // variance along the bone, and the traces of the covariance and of its
  // square. The bone's direction is taken from the estimate: in a single frame,
  // noise rotates the bone towards the direction of largest noise, so that
  // observations that are too long would be assigned large noise, and the mean
  // of the remaining ones would be too short.
  double added_m = 0.0;
  double variance_m2 = 0.0;
  double noise_m2 = 0.0;
  double noise_square_m4 = 0.0;
};

// nullopt if both ends are at the same position, observed or estimated.
std::optional<BoneObservation> LookAtBone(const BoneEnd& a, const BoneEnd& b);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_NOISE_BONE_LOOKS_H_
