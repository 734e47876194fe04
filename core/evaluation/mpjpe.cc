#include "core/evaluation/mpjpe.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <map>

namespace kinegraph {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// A body axis shorter than this has no direction [m].
constexpr double kLeastAxisM = 1e-3;

// One joint of one true person that was found.
struct Residual {
  size_t person_idx = 0;
  size_t joint_idx = 0;         // in the pairs
  Vector3d found_minus_true_m;  // in the body frame if there is one
  bool in_body_frame = false;
};

// r_NAME - l_NAME; nullopt when one is missing.
std::optional<Vector3d> Across(const Pose3d& pose, const Skeleton& skeleton,
                               const std::string& name) {
  const int l = skeleton.IndexOf("l_" + name);
  const int r = skeleton.IndexOf("r_" + name);
  if (l < 0 || r < 0 || !pose[l].present() || !pose[r].present()) {
    return std::nullopt;
  }
  return pose[r].position_m - pose[l].position_m;
}

std::vector<Residual> Residuals(const std::vector<PersonPair>& pairs,
                                const JointPairs& joints,
                                const Skeleton& skeleton, const Vector3d& up,
                                MpjpeResult* result) {
  std::vector<Residual> residuals;
  for (size_t i = 0; i < pairs.size(); ++i) {
    result->found.Add(pairs[i].found != nullptr);
    if (pairs[i].found == nullptr) continue;
    const Pose3d& truth = pairs[i].truth->joints;
    const std::optional<Matrix3d> body = BodyFrame(truth, skeleton, up);
    for (size_t j = 0; j < joints.size(); ++j) {
      const Joint3d& expected = truth[joints[j].a];
      const Joint3d& found = pairs[i].found->joints[joints[j].b];
      if (!expected.present()) continue;
      result->joints_found.Add(found.present());
      if (!found.present()) continue;
      const Vector3d difference = found.position_m - expected.position_m;
      residuals.push_back(
          {i, j, body ? Vector3d(body->transpose() * difference) : difference,
           body.has_value()});
    }
  }
  return residuals;
}

std::vector<Vector3d> Offsets(const std::vector<Residual>& residuals,
                              size_t joint_count) {
  std::vector<std::vector<double>> values(joint_count * 3);
  for (const Residual& residual : residuals) {
    if (!residual.in_body_frame) continue;
    for (int axis = 0; axis < 3; ++axis) {
      values[residual.joint_idx * 3 + axis].push_back(
          residual.found_minus_true_m[axis]);
    }
  }
  std::vector<Vector3d> offsets(joint_count, Vector3d::Zero());
  for (size_t i = 0; i < values.size(); ++i) {
    if (!values[i].empty()) offsets[i / 3][i % 3] = Quantile(values[i], 0.5);
  }
  return offsets;
}

// Sums that become means.
struct ErrorSum {
  double raw_m = 0.0;
  double bias_removed_m = 0.0;
  int64_t count = 0;
};

double Divide(double sum, int64_t count) {
  if (count == 0) return std::numeric_limits<double>::quiet_NaN();
  return sum / static_cast<double>(count);
}

Interval PersonInterval(const std::vector<PersonError>& people,
                        double PersonError::*error,
                        const BootstrapOptions& options) {
  std::vector<RatioSeries> series;  // one an actor
  for (size_t i = 0; i < people.size(); ++i) {
    if (i == 0 || people[i].actor != people[i - 1].actor) series.emplace_back();
    series.back().push_back(
        {people[i].*error, static_cast<double>(people[i].joint_count)});
  }
  return PooledRatioInterval(series, options);
}

}  // namespace

std::optional<Matrix3d> BodyFrame(const Pose3d& pose, const Skeleton& skeleton,
                                  const Vector3d& up) {
  Vector3d across = Vector3d::Zero();
  for (const char* name : {"shoulder", "hip"}) {
    if (const auto one = Across(pose, skeleton, name)) across += *one;
  }
  const Vector3d vertical = up.normalized();
  const Vector3d level = across - across.dot(vertical) * vertical;
  if (level.norm() < kLeastAxisM) return std::nullopt;
  Matrix3d body;
  body.col(0) = level.normalized();
  body.col(1) = vertical.cross(body.col(0));
  body.col(2) = vertical;
  return body;
}

MpjpeResult EvaluateMpjpe(const TrackSequence& truth,
                          const TrackSequence& tracks,
                          const MpjpeOptions& options,
                          const BootstrapOptions& bootstrap) {
  const Skeleton& skeleton = truth.header.skeleton;
  const JointPairs joints = CommonJoints(skeleton, tracks.header.skeleton);
  MpjpeResult result;
  const std::vector<PersonPair> pairs =
      PairPeople(truth, tracks, joints, kPersonGateM, options.frames);
  const std::vector<Residual> residuals =
      Residuals(pairs, joints, skeleton, options.up, &result);
  const std::vector<Vector3d> offsets = Offsets(residuals, joints.size());

  for (const PersonPair& pair : pairs) {
    result.people.push_back({pair.frame, pair.truth->id.value(), 0, 0.0, 0.0});
  }
  std::vector<ErrorSum> of_joint(joints.size());
  ErrorSum total;
  for (const Residual& residual : residuals) {
    const double raw_m = residual.found_minus_true_m.norm();
    const double bias_removed_m =
        residual.in_body_frame
            ? (residual.found_minus_true_m - offsets[residual.joint_idx]).norm()
            : raw_m;
    for (ErrorSum* sum : {&of_joint[residual.joint_idx], &total}) {
      sum->raw_m += raw_m;
      sum->bias_removed_m += bias_removed_m;
      ++sum->count;
    }
    PersonError& person = result.people[residual.person_idx];
    person.raw_m += raw_m;
    person.bias_removed_m += bias_removed_m;
    ++person.joint_count;
  }
  std::stable_sort(result.people.begin(), result.people.end(),
                   [](const PersonError& a, const PersonError& b) {
                     return a.actor != b.actor ? a.actor < b.actor
                                               : a.frame < b.frame;
                   });
  for (size_t j = 0; j < joints.size(); ++j) {
    const ErrorSum& sum = of_joint[j];
    result.joints.push_back({skeleton.joints()[joints[j].a], sum.count,
                             Divide(sum.raw_m, sum.count), offsets[j],
                             Divide(sum.bias_removed_m, sum.count)});
  }
  result.raw_m = Divide(total.raw_m, total.count);
  result.bias_removed_m = Divide(total.bias_removed_m, total.count);
  result.raw_interval =
      PersonInterval(result.people, &PersonError::raw_m, bootstrap);
  result.bias_removed_interval =
      PersonInterval(result.people, &PersonError::bias_removed_m, bootstrap);
  return result;
}

}  // namespace kinegraph
