#include "core/evaluation/consistency.h"

#include <Eigen/Cholesky>

#include "core/evaluation/correspondence.h"

namespace kinegraph {
namespace {

Consistency Summarise(const std::vector<double>& squared, int dof,
                      double limit) {
  Consistency consistency;
  for (const double one : squared) consistency.covered.Add(one <= limit);
  consistency.nees_per_dof = Mean(squared) / dof;
  return consistency;
}

}  // namespace

Consistency CovariancesAgainstTruth(const TrackSequence& truth,
                                    const TrackSequence& tracks,
                                    const std::vector<FrameRange>& frames) {
  const JointPairs joints =
      CommonJoints(truth.header.skeleton, tracks.header.skeleton);
  std::vector<double> squared;
  for (const PersonPair& pair :
       PairPeople(truth, tracks, joints, kPersonGateM, frames)) {
    if (pair.found == nullptr || pair.found->covariances.empty()) continue;
    for (const JointPair& joint : joints) {
      const Joint3d& expected = pair.truth->joints[joint.a];
      const Joint3d& found = pair.found->joints[joint.b];
      const auto& covariance = pair.found->covariances[joint.b];
      if (!expected.present() || !found.present() || !covariance) continue;
      const Eigen::Vector3d error = found.position_m - expected.position_m;
      squared.push_back(error.dot(covariance->ldlt().solve(error)));
    }
  }
  return Summarise(squared, 3, kChiSquare95Of3);
}

Consistency HeldOutConsistency(const HeldOutScores& scores) {
  std::vector<double> squared;
  for (const HeldOutJoint& joint : scores.joints) {
    if (joint.normalised_squared) squared.push_back(*joint.normalised_squared);
  }
  return Summarise(squared, 2, kChiSquare95Of2);
}

}  // namespace kinegraph
