// How well a 2D pose fits a 3D pose (paper Eq. 1).
#ifndef KINEGRAPH_CORE_ASSOCIATION_AFFINITY_H_
#define KINEGRAPH_CORE_ASSOCIATION_AFFINITY_H_

#include <Eigen/Core>
#include <vector>

#include "core/base/options.h"
#include "core/data/observation.h"
#include "core/data/pose.h"
#include "core/geometry/camera.h"

namespace kinegraph {

enum class AffinityKind {
  kPart,  // mean over the joints with a positive affinity (the paper's)
  kBody,  // mean over all joints (the ablation's baseline)
};

struct AssociationOptions {
  AffinityKind affinity = AffinityKind::kPart;
  double alpha_2d_px_per_frame = 70.0;
  double lambda_a_per_frame = 3.0;
  // Joints of 17 that must have a positive affinity. Where joints are missing
  // the same share of the joints that both poses have.
  double epsilon_joints = 10.0;
  // Of 17; fewer common joints than this are no match at all.
  double min_common_joints = 6.0;

  void Describe(OptionVisitor& visitor);
};

// A 3D pose projected into one view.
struct ProjectedPose {
  std::vector<Eigen::Vector2d> px;  // raw pixels
  std::vector<char> valid;          // one a joint
};

// Projects the joints listed in `joints`; others become not valid. A joint
// without a position, behind the camera or beyond the lens is not valid.
void ProjectPose(const Pose3d& pose, const Camera& camera,
                 const std::vector<int>& joints, ProjectedPose* projected);

// Affinity of an observation to a projected pose that is `age_frames` old
// (> 0), over the joints listed that both have. 0 means no match; body-aware
// affinities may be negative.
double Affinity(const Observation& observation, const ProjectedPose& projected,
                double age_frames, const std::vector<int>& joints,
                const AssociationOptions& options);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_ASSOCIATION_AFFINITY_H_
