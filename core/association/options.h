// Options of the association, table [association].
#ifndef KINEGRAPH_CORE_ASSOCIATION_OPTIONS_H_
#define KINEGRAPH_CORE_ASSOCIATION_OPTIONS_H_

#include "core/base/options.h"

namespace kinegraph {

enum class AffinityKind {
  kPart,  // mean over the joints with a positive affinity (the paper's)
  kBody,  // mean over all joints (the ablation's baseline)
  // Chen et al.: a sum over joints of what the last 2D joint of this view and
  // the expected 3D joint say.
  kCrossView,
};

// cross_view: what a detected joint is compared with in the image.
enum class Target2d {
  kMatched,    // the joint that was last matched to the person in this view
  kProjected,  // the projection of the person's last 3D joint
};

struct AssociationOptions {
  AffinityKind affinity = AffinityKind::kPart;
  double alpha_2d_px_per_frame = 70.0;
  double lambda_a_per_frame = 3.0;
  // Graph mode: after the first frame without a match the gate of Eq. 1 grows
  // no faster than people move. The paper's grows by alpha_2d a frame and soon
  // reaches strangers. 0: the paper's.
  double max_speed_mps = 3.0;
  // Graph mode: so long a person is expected to go on as their body went; then
  // they stay. 0: expected where they were last seen, the paper's.
  double prediction_s = 0.2;
  // Joints of 17 that must have a positive affinity. Where joints are missing
  // the same share of the joints that both poses have.
  double epsilon_joints = 10.0;
  // Of 17; fewer common joints than this are no match at all.
  double min_common_joints = 6.0;
  // cross_view alone.
  Target2d target_2d = Target2d::kMatched;
  double alpha_3d_m = 0.15;

  // Chen et al.'s weights of the distances in the image and from the ray.
  double weight_2d = 0.4;
  double weight_3d = 0.6;

  // Set by the tracker from max_speed, no key; 0: the gate is the paper's.
  double reach_m_per_frame = 0.0;
  // Likewise prediction_s in graph mode, 0 in paper mode.
  double horizon_s = 0.0;

  void Describe(OptionVisitor& visitor);
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_ASSOCIATION_OPTIONS_H_
