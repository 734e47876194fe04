#include "solvers/graph/outcome.h"

#include <algorithm>

namespace kinegraph {

int CountInliers(const JointChain& chain, size_t k, double inlier_weight) {
  int count = 0;
  for (int32_t m = chain.first[k]; m < chain.first[k + 1]; ++m) {
    const PixelMeasurement& measurement = chain.measurements[m];
    if (!measurement.gated && measurement.weight >= inlier_weight) ++count;
  }
  return count;
}

void Extend(TimeNs time, int inlier_views, JointSupport* support) {
  if (inlier_views == 0) return;
  support->by_two_views |= inlier_views >= 2;
  support->by_one_view = true;
  support->last_time = time;
}

JointStatus StatusOf(int inlier_views, bool ever_two_views,
                     double nearest_support_s, double bridging_limit_s) {
  if (!ever_two_views) return JointStatus::kMissing;
  if (inlier_views >= 2) return JointStatus::kObserved;
  // Half a millisecond of slack: frame times are rounded to nanoseconds.
  constexpr double kSlack = 5e-4;
  return nearest_support_s <= bridging_limit_s + kSlack ? JointStatus::kInferred
                                                        : JointStatus::kMissing;
}

FinalPose PoseOf(const FrameRecord& record, int joint_count, KeptMatches kept,
                 bool covariances) {
  FinalPose pose;
  pose.frame = record.frame;
  pose.time = record.time;
  PersonPose& person = pose.person;
  person.score = record.score;
  person.joints.resize(joint_count);
  person.inlier_views.assign(joint_count, 0);
  if (covariances) person.covariances.resize(joint_count);
  if (kept == KeptMatches::kNone) return pose;
  person.matches.reserve(record.views.size());
  for (const FrameRecord::View& view : record.views) {
    ViewMatch match;
    match.view_idx = view.view_idx;
    match.detection_idx = view.detection_idx;
    if (kept == KeptMatches::kWeights) match.weights.resize(joint_count);
    person.matches.push_back(std::move(match));
  }
  return pose;
}

void WriteJoint(const JointChain& chain, size_t k, int joint_idx,
                JointStatus status, int inlier_views,
                const Eigen::Matrix3d* covariance, PersonPose* pose) {
  Joint3d& joint = pose->joints[joint_idx];
  joint.status = status;
  pose->inlier_views[joint_idx] = inlier_views;
  if (joint.present()) {
    joint.position_m = chain.states[k].head<3>();
    if (covariance != nullptr) pose->covariances[joint_idx] = *covariance;
  }
  if (pose->matches.empty() || pose->matches.front().weights.empty()) return;
  for (int32_t m = chain.first[k]; m < chain.first[k + 1]; ++m) {
    const PixelMeasurement& measurement = chain.measurements[m];
    pose->matches[measurement.view_slot].weights[joint_idx] =
        measurement.gated ? 0.0 : measurement.weight;
  }
}

}  // namespace kinegraph
