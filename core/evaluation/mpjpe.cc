#include "core/evaluation/mpjpe.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/base/constants.h"

namespace kinegraph {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// A body axis shorter than this has no direction [m].
constexpr double kLeastAxisM = 1e-3;

// One joint of one true person that was found.
struct Residual {
  size_t person_idx = 0;
  size_t joint_idx = 0;         // index of the joint pair
  Vector3d found_minus_true_m;  // in the body frame if defined
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

void AddNear(const PersonPair& pair, const JointPairs& joints,
             MpjpeResult* result) {
  for (const JointPair& joint : joints) {
    const Joint3d& expected = pair.truth->joints[joint.a];
    if (!expected.present()) continue;
    double distance_m = kNoGate;
    if (pair.found != nullptr && pair.found->joints[joint.b].present()) {
      distance_m =
          (pair.found->joints[joint.b].position_m - expected.position_m).norm();
    }
    for (size_t i = 0; i < result->pck.size(); ++i) {
      result->pck[i].Add(distance_m < result->pck_m[i]);
    }
  }
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
  if (count == 0) return kNan;
  return sum / static_cast<double>(count);
}

Interval PersonInterval(const std::vector<PersonError>& people,
                        double PersonError::*error,
                        const BootstrapOptions& options) {
  std::vector<RatioSeries> series;  // one per actor
  for (size_t i = 0; i < people.size(); ++i) {
    if (i == 0 || people[i].actor != people[i - 1].actor) series.emplace_back();
    series.back().push_back(
        {people[i].*error, static_cast<double>(people[i].joint_count)});
  }
  return RatioInterval(PooledRatio, series, options);
}

// Squared Mahalanobis distance that contains 95 % of normal errors: the
// quantile of chi-square with three degrees of freedom.
constexpr double kChiSquare95Of3 = 7.814727903251179;

struct ConsistencySums {
  int64_t count = 0;
  double squared_m2 = 0.0;
  Share covered;
  double nees = 0.0;
  double trace_m2 = 0.0;
  int64_t definite = 0;

  void Add(const Vector3d& error_m, const std::optional<Matrix3d>& covariance) {
    ++count;
    squared_m2 += error_m.squaredNorm();
    if (!covariance.has_value()) return;
    const Eigen::LLT<Matrix3d> root(*covariance);
    if (root.info() != Eigen::Success) {
      covered.Add(false);
      return;
    }
    const double distance = root.matrixL().solve(error_m).squaredNorm();
    covered.Add(distance <= kChiSquare95Of3);
    nees += distance / 3.0;
    trace_m2 += covariance->trace();
    ++definite;
  }

  // Adds only what Stated() needs.
  ConsistencySums& operator+=(const ConsistencySums& other) {
    covered += other.covered;
    nees += other.nees;
    definite += other.definite;
    return *this;
  }

  Consistency Stated() const {
    return {covered, nees / static_cast<double>(definite)};
  }

  ConsistencyRow Row(JointStatus status) const {
    ConsistencyRow row;
    row.status = status;
    row.count = count;
    row.rmse_m =
        count > 0 ? std::sqrt(squared_m2 / static_cast<double>(count)) : kNan;
    row.stated = Stated();
    row.stated_rms_m = definite > 0
                           ? std::sqrt(trace_m2 / static_cast<double>(definite))
                           : kNan;
    return row;
  }
};

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

RatioUnit AlignedError(const Pose3d& truth, const Pose3d& found,
                       const JointPairs& joints) {
  Eigen::Matrix3Xd true_m(3, joints.size());
  Eigen::Matrix3Xd found_m(3, joints.size());
  Eigen::Index common = 0;
  for (const JointPair& joint : joints) {
    const Joint3d& expected = truth[joint.a];
    const Joint3d& one = found[joint.b];
    if (!expected.present() || !one.present()) continue;
    true_m.col(common) = expected.position_m;
    found_m.col(common++) = one.position_m;
  }
  if (common < 3) return {};
  const Eigen::Matrix3Xd to = true_m.leftCols(common);
  const Eigen::Matrix3Xd from = found_m.leftCols(common);
  const Eigen::Matrix4d fit = Eigen::umeyama(from, to, true);
  const Eigen::Matrix3Xd aligned =
      (fit.topLeftCorner<3, 3>() * from).colwise() +
      Vector3d(fit.topRightCorner<3, 1>());
  return {(aligned - to).colwise().norm().sum(), static_cast<double>(common)};
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

  RatioSeries aligned;
  result.pck.resize(result.pck_m.size());
  for (const PersonPair& pair : pairs) {
    result.people.push_back({pair.frame, pair.truth->id.value(), 0, 0.0, 0.0});
    AddNear(pair, joints, &result);
    if (pair.found == nullptr) continue;
    aligned.push_back(
        AlignedError(pair.truth->joints, pair.found->joints, joints));
  }
  result.aligned_m = PooledRatio({aligned});
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
  SortByActorAndFrame(&result.people);
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

ConsistencyResult EvaluateConsistency(const TrackSequence& truth,
                                      const TrackSequence& tracks,
                                      const std::vector<FrameRange>& frames) {
  const JointPairs joints =
      CommonJoints(truth.header.skeleton, tracks.header.skeleton);
  ConsistencySums observed;
  ConsistencySums inferred;
  for (const PersonPair& pair :
       PairPeople(truth, tracks, joints, kPersonGateM, frames)) {
    if (pair.found == nullptr) continue;
    for (const JointPair& joint : joints) {
      const Joint3d& expected = pair.truth->joints[joint.a];
      const Joint3d& found = pair.found->joints[joint.b];
      if (!expected.present() || !found.present()) continue;
      const std::vector<std::optional<Eigen::Matrix3d>>& stated =
          pair.found->covariances;
      ConsistencySums& sums =
          found.status == JointStatus::kObserved ? observed : inferred;
      sums.Add(found.position_m - expected.position_m,
               stated.empty() ? std::nullopt : stated[joint.b]);
    }
  }
  ConsistencySums all = observed;
  all += inferred;
  return {observed.Row(JointStatus::kObserved),
          inferred.Row(JointStatus::kInferred), all.Stated()};
}

}  // namespace kinegraph
