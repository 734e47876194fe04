#include "solvers/graph/outcome.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>

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
  // Far above the rounding of frame times (1 ns), far below a frame interval.
  constexpr double kSlack = 5e-4;
  return nearest_support_s <= bridging_limit_s + kSlack ? JointStatus::kInferred
                                                        : JointStatus::kMissing;
}

FinalPose PoseOf(const FrameRecord& record, const SceneModel& scene,
                 bool covariances) {
  const int joint_count = scene.skeleton.joint_count();
  const KeptMatches kept = scene.kept_matches;
  FinalPose pose;
  pose.frame = record.frame;
  pose.time = record.time;
  PersonPose& person = pose.person;
  person.score = record.score;
  person.joints.resize(joint_count);
  person.inlier_views.assign(joint_count, 0);
  if (covariances) person.covariances.resize(joint_count);
  if (scene.keep_derivatives) person.derivatives.resize(joint_count);
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
    if (!pose->derivatives.empty()) {
      pose->derivatives[joint_idx].emplace().velocity_m_s =
          chain.states[k].tail<3>();
    }
    if (covariance != nullptr) pose->covariances[joint_idx] = *covariance;
  }
  if (pose->matches.empty() || pose->matches.front().weights.empty()) return;
  for (int32_t m = chain.first[k]; m < chain.first[k + 1]; ++m) {
    const PixelMeasurement& measurement = chain.measurements[m];
    pose->matches[measurement.view_slot].weights[joint_idx] =
        measurement.gated ? 0.0 : measurement.weight;
  }
}

namespace {

// Fraction of a bone's length: a joint with a larger uncertainty may be on
// either side of its neighbour.
constexpr double kShareOfBone = 0.5;
// Fraction of the longest bone. Limbs exceed it; bones of the face (RigidPairs)
// do not: the longest, ear to ear, measures 0.14 m, a thigh 0.45 m.
constexpr double kShareOfLimb = 1.0 / 3.0;

// Joints whose reported standard deviation is too large for their bones.
std::vector<char> FindUnsure(const std::vector<KnownBone>& bones,
                             const PersonPose& pose) {
  const size_t joints = pose.joints.size();
  std::vector<double> longest_m(joints, 0.0);
  for (const KnownBone& bone : bones) {
    for (const int end : {bone.ends.a, bone.ends.b}) {
      longest_m[end] = std::max(longest_m[end], bone.length_m);
    }
  }
  // The bones of the face are shorter than the typical error of its joints. For
  // these joints, and for joints without a measured bone, the limit is that of
  // the body's longest bone.
  const double any_m = *std::max_element(longest_m.begin(), longest_m.end());
  for (double& length_m : longest_m) {
    if (length_m < kShareOfLimb * any_m) length_m = any_m;
  }
  std::vector<char> unsure(joints, 0);
  for (size_t j = 0; j < pose.covariances.size(); ++j) {
    const std::optional<Eigen::Matrix3d>& covariance = pose.covariances[j];
    if (!pose.joints[j].present() || !covariance || longest_m[j] == 0.0) {
      continue;
    }
    const double most_m = kShareOfBone * longest_m[j];
    // The trace is an upper bound of the greatest eigenvalue.
    if (covariance->trace() <= most_m * most_m) continue;
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
    solver.computeDirect(*covariance, Eigen::EigenvaluesOnly);
    unsure[j] = !(solver.eigenvalues()[2] <= most_m * most_m);
  }
  return unsure;
}

// For each joint, the lowest index among the joints connected with it by bones
// that keep their lengths.
std::vector<int> FindParts(const std::vector<KnownBone>& bones,
                           const PersonPose& pose) {
  std::vector<int> part(pose.joints.size());
  std::iota(part.begin(), part.end(), 0);
  for (const KnownBone& bone : bones) {
    const Joint3d& a = pose.joints[bone.ends.a];
    const Joint3d& b = pose.joints[bone.ends.b];
    if (!a.present() || !b.present()) continue;
    const double off_m =
        std::abs((a.position_m - b.position_m).norm() - bone.length_m);
    if (!(off_m <= kShareOfBone * bone.length_m)) continue;
    const int from = std::max(part[bone.ends.a], part[bone.ends.b]);
    const int to = std::min(part[bone.ends.a], part[bone.ends.b]);
    std::replace(part.begin(), part.end(), from, to);
  }
  return part;
}

}  // namespace

void DropUnsureJoints(const std::vector<KnownBone>& bones, PersonPose* pose) {
  const std::vector<char> unsure = FindUnsure(bones, *pose);
  if (std::find(unsure.begin(), unsure.end(), 1) == unsure.end()) return;
  const std::vector<int> part = FindParts(bones, *pose);
  const int present = CountPresent(pose->joints);
  std::vector<int> size(part.size(), 0);
  std::vector<char> has_sure(part.size(), 0);
  for (size_t j = 0; j < part.size(); ++j) {
    if (!pose->joints[j].present()) continue;
    ++size[part[j]];
    has_sure[part[j]] |= !unsure[j];
  }
  for (size_t j = 0; j < part.size(); ++j) {
    if (!unsure[j] || has_sure[part[j]] || 2 * size[part[j]] > present) {
      continue;
    }
    pose->joints[j].status = JointStatus::kMissing;
    pose->covariances[j].reset();
    if (!pose->derivatives.empty()) pose->derivatives[j].reset();
  }
}

}  // namespace kinegraph
