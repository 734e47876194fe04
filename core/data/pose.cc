#include "core/data/pose.h"

#include <algorithm>

namespace kinegraph {

const char* ToString(JointStatus status) {
  static constexpr const char* kNames[] = {"missing", "inferred", "observed"};
  return kNames[static_cast<int>(status)];
}

int CountPresent(const Pose3d& pose) {
  return static_cast<int>(
      std::count_if(pose.begin(), pose.end(),
                    [](const Joint3d& joint) { return joint.present(); }));
}

std::optional<Eigen::Vector3d> MeanPosition(const Pose3d& pose) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0;
  for (const Joint3d& joint : pose) {
    if (!joint.present() || !joint.position_m.allFinite()) continue;
    sum += joint.position_m;
    ++count;
  }
  if (count == 0) return std::nullopt;
  return Eigen::Vector3d(sum / count);
}

std::optional<double> MeanDistance(const Pose3d& a, const Pose3d& b) {
  double sum_m = 0.0;
  int count = 0;
  for (size_t j = 0; j < std::min(a.size(), b.size()); ++j) {
    if (!a[j].present() || !b[j].present()) continue;
    sum_m += (a[j].position_m - b[j].position_m).norm();
    ++count;
  }
  if (count == 0) return std::nullopt;
  return sum_m / count;
}

void Scale(double factor, TrackFrame* frame) {
  for (PersonPose& person : frame->people) {
    for (Joint3d& joint : person.joints) joint.position_m *= factor;
    for (auto& covariance : person.covariances) {
      if (covariance.has_value()) *covariance *= factor * factor;
    }
    for (auto& derivatives : person.derivatives) {
      if (!derivatives.has_value()) continue;
      derivatives->velocity_m_s *= factor;
      if (!derivatives->acceleration_m_s2.has_value()) continue;
      *derivatives->acceleration_m_s2 *= factor;
    }
  }
}

}  // namespace kinegraph
