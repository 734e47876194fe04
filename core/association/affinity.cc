#include "core/association/affinity.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace kinegraph {

void AssociationOptions::Describe(OptionVisitor& visitor) {
  visitor.Choice("affinity", &affinity, {"part", "body"},
                 "mean over positive joints (part) or over all (body)");
  visitor.Number("alpha_2d", &alpha_2d_px_per_frame, Positive(), "px per frame",
                 "2D speed at which a joint's affinity falls to zero (Eq. 1)");
  visitor.Number("lambda_a", &lambda_a_per_frame, NonNegative(), "1/frame",
                 "decay of the affinity with the age of the 3D pose (Eq. 1)");
  visitor.Number("epsilon", &epsilon_joints, Between(0.0, 17.0), "joints of 17",
                 "share of the common joints that must be positive");
  visitor.Number("min_common_joints", &min_common_joints, Between(0.0, 17.0),
                 "joints of 17", "fewer common joints are no match");
}

void ProjectPose(const Pose3d& pose, const Camera& camera,
                 const std::vector<int>& joints, ProjectedPose* projected) {
  projected->px.resize(pose.size());
  projected->valid.assign(pose.size(), 0);
  for (const int j : joints) {
    if (!pose[j].present()) continue;
    const std::optional<Eigen::Vector2d> px =
        camera.Project(pose[j].position_m);
    if (!px.has_value()) continue;
    projected->px[j] = *px;
    projected->valid[j] = 1;
  }
}

double Affinity(const Observation& observation, const ProjectedPose& projected,
                double age_frames, const std::vector<int>& joints,
                const AssociationOptions& options) {
  const double scale = 1.0 / (options.alpha_2d_px_per_frame * age_frames);
  int common = 0;
  int positive = 0;
  double positive_sum = 0.0;
  double sum = 0.0;
  for (const int j : joints) {
    if (!projected.valid[j] || !observation.joints[j].found) continue;
    ++common;
    const double distance_px =
        (observation.joints[j].px - projected.px[j]).norm();
    const double affinity = 1.0 - distance_px * scale;
    sum += affinity;
    if (affinity > 0.0) {
      ++positive;
      positive_sum += affinity;
    }
  }
  if (common == 0 ||
      common < ScaledJoints(options.min_common_joints, joints.size())) {
    return 0.0;
  }
  const double decay = std::exp(-options.lambda_a_per_frame * age_frames);
  if (options.affinity == AffinityKind::kBody) return sum / common * decay;
  if (positive == 0 || positive < ScaledJoints(options.epsilon_joints,
                                               static_cast<size_t>(common))) {
    return 0.0;
  }
  return positive_sum / positive * decay;
}

}  // namespace kinegraph
