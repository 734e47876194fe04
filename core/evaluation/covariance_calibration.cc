#include "core/evaluation/covariance_calibration.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>
#include <optional>

#include "core/base/constants.h"

namespace kinegraph {
namespace {

struct Sums {
  int64_t count = 0;
  double squared_m2 = 0.0;
  Share covered;
  double nees = 0.0;
  double trace_m2 = 0.0;
  int64_t definite = 0;

  void Add(const Eigen::Vector3d& error_m,
           const std::optional<Eigen::Matrix3d>& covariance) {
    ++count;
    squared_m2 += error_m.squaredNorm();
    if (!covariance.has_value()) return;
    const Eigen::LLT<Eigen::Matrix3d> root(*covariance);
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

  Sums& operator+=(const Sums& other) {
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

ConsistencyResult EvaluateConsistency(const TrackSequence& truth,
                                      const TrackSequence& tracks,
                                      const std::vector<FrameRange>& frames) {
  const JointPairs joints =
      CommonJoints(truth.header.skeleton, tracks.header.skeleton);
  Sums observed;
  Sums inferred;
  for (const PersonPair& pair :
       PairPeople(truth, tracks, joints, kPersonGateM, frames)) {
    if (pair.found == nullptr) continue;
    for (const JointPair& joint : joints) {
      const Joint3d& expected = pair.truth->joints[joint.a];
      const Joint3d& found = pair.found->joints[joint.b];
      if (!expected.present() || !found.present()) continue;
      const std::vector<std::optional<Eigen::Matrix3d>>& stated =
          pair.found->covariances;
      Sums& sums = found.status == JointStatus::kObserved ? observed : inferred;
      sums.Add(found.position_m - expected.position_m,
               stated.empty() ? std::nullopt : stated[joint.b]);
    }
  }
  Sums all = observed;
  all += inferred;
  return {observed.Row(JointStatus::kObserved),
          inferred.Row(JointStatus::kInferred), all.Stated()};
}

Consistency HeldOutConsistency(const HeldOutScores& scores) {
  Consistency consistency;
  std::vector<double> squared;
  for (const HeldOutJoint& joint : scores.joints) {
    if (!joint.normalised_squared.has_value()) continue;
    squared.push_back(*joint.normalised_squared);
    consistency.covered.Add(squared.back() <= kChiSquare95Of2);
  }
  consistency.nees_per_dof = Mean(squared) / 2.0;
  return consistency;
}

}  // namespace kinegraph
