// The bones of a skeleton, and as the views of single frames show them: no
// motion prior has a say.
#ifndef KINEGRAPH_SOLVERS_NOISE_BONE_LOOKS_H_
#define KINEGRAPH_SOLVERS_NOISE_BONE_LOOKS_H_

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/skeleton/skeleton.h"
#include "solvers/graph/problem.h"

namespace kinegraph {

// Length of that bone of an adult [m], from segment lengths as shares of a
// stature of 1.70 m (Drillis and Contini 1966, as in Winter, Biomechanics and
// Motor Control of Human Movement, fig. 4.1); nullopt for other bones.
std::optional<double> PopulationLength(const std::string& joint_a,
                                       const std::string& joint_b);

// Pairs of joints whose distance a person keeps: the skeleton's bones, and of a
// human the remaining pairs of nose, eyes and ears, which one rigid head
// carries.
std::vector<Bone> RigidPairs(const Skeleton& skeleton);

// Whether it is the bone between `a` and `b`, in either order.
bool SameBone(const Bone& bone, int a, int b);

// Where a joint stands in one frame by its views alone, so that neither motion
// prior nor bones have a say.
struct BoneEnd {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  // Where the solver has it: what the frame's own noise has hardly a part in.
  Eigen::Vector3d estimate_m = Eigen::Vector3d::Zero();
  // For the modelled noise of the pixels.
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Identity();
  // Squared residuals in sigmas and their degrees of freedom (2 views - 3): how
  // right the modelled noise is.
  double square = 0.0;
  int freedom = 0;
  // Over so many frames the solver averages the joint's position.
  double averaged_frames = 1.0;
};

// One a joint; nullopt where fewer than two views count (weight of at least
// `inlier_weight` at the estimate) or they leave a direction open.
// `interval_s`: between frames.
std::vector<std::optional<BoneEnd>> LocateBoneEnds(const PersonProblem& problem,
                                                   size_t frame_idx,
                                                   double inlier_weight,
                                                   double interval_s);

// One look at a bone.
struct BoneObservation {
  double distance_m = 0.0;
  double square = 0.0;  // of both ends
  int freedom = 0;
  double averaged_frames = 1.0;
  // For the modelled noise of the pixels: what it adds to every distance,
  // variance along the bone, trace of its covariance and of that one's square.
  // The bone's direction is the estimate's. Where a frame's noise is long, it
  // turns the bone towards itself: by its own direction a look that is too long
  // would count as a noisy one, and what is left would be too short.
  double added_m = 0.0;
  double variance_m2 = 0.0;
  double noise_m2 = 0.0;
  double noise_square_m4 = 0.0;
};

// nullopt where both ends are, or are estimated, at the same place.
std::optional<BoneObservation> LookAtBone(const BoneEnd& a, const BoneEnd& b);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_NOISE_BONE_LOOKS_H_
