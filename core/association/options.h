// Options of the association, table [association]. "The paper" is Chu et al.
// (2021).
#ifndef KINEGRAPH_CORE_ASSOCIATION_OPTIONS_H_
#define KINEGRAPH_CORE_ASSOCIATION_OPTIONS_H_

#include "core/base/options.h"

namespace kinegraph {

// The fewest common joints with which graph mode matches a detection with a
// person, and the fewest joints that a new person may have, of 17. Numbers of
// joints "of 17" are scaled to the joints of the skeleton (ScaledJoints).
inline constexpr double kFewestJoints = 4.0;

enum class AffinityKind {
  kPart,  // mean over the joints with a positive affinity (the paper's)
  kBody,  // mean over all joints (the baseline of the paper's ablation)
  // Chen et al.: a sum over joints of two terms, the distance from the last 2D
  // joint in this view and from the expected 3D joint.
  kCrossView,
};

// cross_view: the point with which a detected joint is compared in the image.
enum class Target2d {
  kMatched,    // the joint that was last matched to the person in this view
  kProjected,  // the projection of the person's last 3D joint
};

struct AssociationOptions {
  AffinityKind affinity = AffinityKind::kPart;
  double alpha_2d_px_per_frame = 70.0;
  double lambda_a_per_frame = 3.0;
  // Graph mode: after the first frame without a match the gate of Eq. 1 grows
  // at most at this speed. The paper's gate grows by alpha_2d per frame and
  // soon includes other people. 0: the paper's gate.
  double max_speed_mps = 3.0;
  // Graph mode: a person is expected to continue with the motion of the body
  // for this long after the last update and then to stand still. 0: expected at
  // the last position, as in the paper.
  double prediction_s = 0.2;
  // part only. Of 17: common joints that must have a positive affinity. Where
  // joints are missing, the same share of the joints that both poses have.
  double epsilon_joints = 10.0;
  // Of 17: a pair with fewer common joints cannot match. Graph mode, unless
  // max_speed is 0 or the affinity is cross_view: four suffice if all common
  // joints agree well.
  double min_common_joints = 6.0;
  // cross_view only.
  Target2d target_2d = Target2d::kMatched;
  double alpha_3d_m = 0.15;

  // Not keys: Chen et al.'s weights of the distances in the image and from the
  // ray.
  double weight_2d = 0.4;
  double weight_3d = 0.6;

  // Not a key: max_speed per frame in graph mode (TrackerOptions::At). 0: the
  // paper's gate.
  double reach_m_per_frame = 0.0;
  // Not a key: prediction_s in graph mode, 0 in paper mode.
  double horizon_s = 0.0;

  void Describe(OptionVisitor& visitor);
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_ASSOCIATION_OPTIONS_H_
