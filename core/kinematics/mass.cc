#include "core/kinematics/mass.h"

#include <string>

namespace kinegraph {
namespace {

// A segment of one side: its share of the mass, and how far from its first to
// its second joint its centre lies, as a share of its length.
struct Segment {
  const char* from;
  const char* to;
  double mass;
  double centre;
};

// The trunk with head and neck (0.578) runs from hip to shoulder, half of it on
// each side.
constexpr Segment kSegments[] = {{"hip", "shoulder", 0.5 * 0.578, 0.66},
                                 {"shoulder", "elbow", 0.028, 0.436},
                                 {"elbow", "wrist", 0.022, 0.682},
                                 {"hip", "knee", 0.100, 0.433},
                                 {"knee", "ankle", 0.061, 0.606}};

}  // namespace

MassWeights MassWeightsOf(const Skeleton& skeleton) {
  std::vector<double> weights(static_cast<size_t>(skeleton.joint_count()));
  for (const std::string side : {"l_", "r_"}) {
    for (const Segment& segment : kSegments) {
      const int from = skeleton.IndexOf(side + segment.from);
      const int to = skeleton.IndexOf(side + segment.to);
      if (from < 0 || to < 0) return {};
      weights[static_cast<size_t>(from)] +=
          segment.mass * (1.0 - segment.centre);
      weights[static_cast<size_t>(to)] += segment.mass * segment.centre;
    }
  }
  MassWeights result;
  for (size_t j = 0; j < weights.size(); ++j) {
    if (weights[j] > 0.0) result.emplace_back(static_cast<int>(j), weights[j]);
  }
  return result;
}

std::optional<Eigen::Vector3d> CentreOfMass(const MassWeights& weights,
                                            const Pose3d& pose) {
  if (weights.empty()) return std::nullopt;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const auto& [joint_idx, weight] : weights) {
    const Joint3d& joint = pose[static_cast<size_t>(joint_idx)];
    if (!joint.present()) return std::nullopt;
    centre += weight * joint.position_m;
  }
  return centre;
}

}  // namespace kinegraph
