#include "core/evaluation/covariance_calibration.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/random.h"
#include "tests/core/evaluation/people.h"

namespace kinegraph::testing {
namespace {

PersonPose Stated(Pose3d joints, const Eigen::Matrix3d& covariance) {
  PersonPose person = Person(0, std::move(joints));
  person.covariances.assign(person.joints.size(), covariance);
  return person;
}

TEST(ConsistencyTest, WorkedByHand) {
  Pose3d moved = StandingTum14();
  moved[0].position_m.x() += 0.02;  // 2 sigmas of 1 cm: 4, inside
  moved[1].position_m.y() += 0.09;  // 3 sigmas of 3 cm: 9, outside
  moved[2].status = JointStatus::kInferred;
  moved[3].status = JointStatus::kMissing;
  const Eigen::Matrix3d covariance =
      Eigen::Vector3d(1e-4, 9e-4, 1e-4).asDiagonal();
  const ConsistencyResult result = EvaluateConsistency(
      Alone(), Tracks({Frame(0, {Stated(moved, covariance)})}));
  EXPECT_EQ(result.observed.count, 12);
  EXPECT_EQ(result.observed.stated.covered.count, 11);
  EXPECT_EQ(result.observed.stated.covered.total, 12);
  EXPECT_NEAR(result.observed.stated.nees_per_dof, (4.0 + 9.0) / 12.0 / 3.0,
              1e-9);
  EXPECT_NEAR(result.observed.rmse_m,
              std::sqrt((0.02 * 0.02 + 0.09 * 0.09) / 12.0), 1e-12);
  EXPECT_NEAR(result.observed.stated_rms_m, std::sqrt(11e-4), 1e-12);
  EXPECT_EQ(result.inferred.count, 1);
  EXPECT_EQ(result.inferred.stated.nees_per_dof, 0.0);
  EXPECT_EQ(result.all.covered.total, 13);
  EXPECT_NEAR(result.all.nees_per_dof, 13.0 / 13.0 / 3.0, 1e-9);
}

TEST(ConsistencyTest, NothingStatedOrNothingDefiniteIsNoCover) {
  const TrackSequence truth = Alone();
  const ConsistencyResult without = EvaluateConsistency(truth, truth);
  EXPECT_EQ(without.observed.count, 14);
  EXPECT_EQ(without.observed.rmse_m, 0.0);
  EXPECT_EQ(without.observed.stated.covered.total, 0);
  EXPECT_TRUE(std::isnan(without.observed.stated.nees_per_dof));
  const ConsistencyResult flat = EvaluateConsistency(
      truth, Tracks({Frame(
                 0, {Stated(StandingTum14(), -Eigen::Matrix3d::Identity())})}));
  EXPECT_EQ(flat.observed.stated.covered.count, 0);
  EXPECT_EQ(flat.observed.stated.covered.total, 14);
  EXPECT_TRUE(std::isnan(flat.observed.stated.nees_per_dof));
}

TEST(ConsistencyTest, RightCovariancesCoverWhatTheySay) {
  Random random(5);
  Eigen::Matrix3d root;  // any lower triangle
  root << 0.02, 0.0, 0.0, 0.01, 0.03, 0.0, -0.005, 0.01, 0.01;
  std::vector<TrackFrame> truth;
  std::vector<TrackFrame> found;
  constexpr int kFrames = 400;
  for (int k = 0; k < kFrames; ++k) {
    truth.push_back(Frame(k, {Person(0, StandingTum14())}));
    Pose3d pose = StandingTum14();
    for (Joint3d& joint : pose) {
      joint.position_m +=
          root *
          Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal());
    }
    found.push_back(Frame(k, {Stated(pose, root * root.transpose())}));
  }
  const ConsistencyRow row =
      EvaluateConsistency(Tracks(truth), Tracks(found)).observed;
  constexpr double kCount = 14.0 * kFrames;
  EXPECT_EQ(row.count, 14 * kFrames);
  // Four standard errors: of a share of 95 %, and of a mean of chi-squares
  // (variance 6) over 3.
  EXPECT_NEAR(row.stated.covered.fraction(), 0.95,
              4.0 * std::sqrt(0.95 * 0.05 / kCount));
  EXPECT_NEAR(row.stated.nees_per_dof, 1.0,
              4.0 * std::sqrt(6.0 / kCount) / 3.0);
}

}  // namespace
}  // namespace kinegraph::testing
