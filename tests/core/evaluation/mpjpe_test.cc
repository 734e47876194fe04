#include "core/evaluation/mpjpe.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "core/base/random.h"
#include "tests/core/evaluation/people.h"

namespace kinegraph::testing {
namespace {

using Eigen::Vector3d;

Pose3d Turned(Pose3d pose, double angle_rad) {
  const Eigen::AngleAxisd turn(angle_rad, Vector3d::UnitZ());
  for (Joint3d& joint : pose) joint.position_m = turn * joint.position_m;
  return pose;
}

TEST(BodyFrameTest, AxesAreRightForwardUp) {
  const auto body = BodyFrame(StandingTum14(), Tum14(), Vector3d::UnitZ());
  ASSERT_TRUE(body.has_value());
  EXPECT_TRUE(body->isApprox(Eigen::Matrix3d::Identity(), 1e-15));
  const auto turned =
      BodyFrame(Turned(StandingTum14(), 1.0), Tum14(), Vector3d::UnitZ());
  EXPECT_NEAR(turned->determinant(), 1.0, 1e-14);
  EXPECT_NEAR(turned->col(0).x(), std::cos(1.0), 1e-14);
  EXPECT_FALSE(BodyFrame(Pose3d(14), Tum14(), Vector3d::UnitZ()).has_value());
  // Lying on the side: right is up.
  EXPECT_FALSE(
      BodyFrame(StandingTum14(), Tum14(), Vector3d::UnitX()).has_value());
}

TEST(MpjpeTest, RawIsTheMeanDistance) {
  Pose3d pose = StandingTum14();
  pose[0].position_m.y() += 0.7;
  const MpjpeResult result = EvaluateMpjpe(Alone(), Alone(pose, 4));
  EXPECT_NEAR(result.raw_m, 0.7 / 14, 1e-15);
  EXPECT_NEAR(result.joints[0].raw_m, 0.7, 1e-15);
  EXPECT_EQ(result.joints[0].joint, "r_ankle");
  EXPECT_EQ(result.joints[1].raw_m, 0.0);
  EXPECT_EQ(result.found.count, 1);
}

TEST(MpjpeTest, AlignedErrorIgnoresASimilarityTransform) {
  Pose3d pose = Turned(StandingTum14(), 0.3);
  for (Joint3d& joint : pose) {
    joint.position_m = 1.1 * joint.position_m + Vector3d(0.05, 0.0, 0.1);
  }
  const MpjpeResult result = EvaluateMpjpe(Alone(), Alone(pose, 4));
  EXPECT_GT(result.raw_m, 0.05);
  EXPECT_NEAR(result.aligned_m, 0.0, 1e-12);
  // The alignment distributes the error of one displaced joint.
  pose = StandingTum14();
  pose[0].position_m.y() += 0.7;
  const MpjpeResult bent = EvaluateMpjpe(Alone(), Alone(pose, 4));
  EXPECT_GT(bent.aligned_m, 0.0);
}

TEST(MpjpeTest, PckCountsMissingJointsAsWrong) {
  Pose3d pose = StandingTum14();
  pose[0].position_m.y() += 0.07;
  pose[1].position_m.y() += 0.12;
  pose[2].position_m.y() += 0.2;
  pose[3].status = JointStatus::kMissing;
  const MpjpeResult result = EvaluateMpjpe(Alone(), Alone(pose, 4));
  EXPECT_EQ(result.pck[0].count, 10);  // 50 mm
  EXPECT_EQ(result.pck[1].count, 11);  // 100 mm
  EXPECT_EQ(result.pck[2].count, 12);  // 150 mm
  EXPECT_EQ(result.pck[2].total, 14);
  // No person within the gate: all joints count as wrong.
  const MpjpeResult alone =
      EvaluateMpjpe(Alone(), Alone(Moved(StandingTum14(), 5.0), 4));
  EXPECT_EQ(alone.pck[2].count, 0);
  EXPECT_EQ(alone.pck[2].total, 14);
  EXPECT_TRUE(std::isnan(alone.aligned_m));
}

TEST(MpjpeTest, AConstantBodyFrameOffsetIsRemoved) {
  // Two people who turn; hips 5 cm too far forward, ankles 3 cm too high.
  Pose3d shifted = StandingTum14();
  for (const int hip : {2, 3}) shifted[hip].position_m.y() += 0.05;
  for (const int ankle : {0, 5}) shifted[ankle].position_m.z() += 0.03;
  const auto turning = [](const Pose3d& pose) {
    std::vector<TrackFrame> frames;
    for (int k = 0; k < 8; ++k) {
      frames.push_back(
          Frame(k, {Person(0, Turned(pose, 0.7 * k)),
                    Person(1, Moved(Turned(pose, -0.4 * k), 5.0))}));
    }
    return Tracks(frames);
  };
  const MpjpeResult result =
      EvaluateMpjpe(turning(StandingTum14()), turning(shifted));
  EXPECT_NEAR(result.raw_m, (2 * 0.05 + 2 * 0.03) / 14, 1e-12);
  EXPECT_NEAR(result.bias_removed_m, 0.0, 1e-12);
  EXPECT_LT((result.joints[2].offset_m - Vector3d(0, 0.05, 0)).norm(), 1e-12);
  EXPECT_LT((result.joints[0].offset_m - Vector3d(0, 0, 0.03)).norm(), 1e-12);
  EXPECT_NEAR(result.raw_interval.low, result.raw_m, 1e-12);
}

TEST(MpjpeTest, LostPeopleAndJointsAreCountedNotAveraged) {
  Pose3d pose = StandingTum14();
  pose[6] = Joint3d{};
  const MpjpeResult result =
      EvaluateMpjpe(Standing("0@0 1@4 | 0@0"), Alone(pose, 8));
  EXPECT_EQ(result.raw_m, 0.0);
  EXPECT_EQ(result.found.count, 1);
  EXPECT_EQ(result.found.total, 3);
  EXPECT_EQ(result.joints_found.count, 13);
  EXPECT_EQ(result.joints_found.total, 14);
  ASSERT_EQ(result.people.size(), 3u);
  EXPECT_EQ(result.people[1].frame, 1);  // by actor, then by frame
  EXPECT_EQ(result.people[2].actor, 1);
  EXPECT_EQ(result.people[2].joint_count, 0);
}

TEST(MpjpeTest, ErrorsAreNaNWithoutMatchedPeople) {
  EXPECT_TRUE(std::isnan(EvaluateMpjpe(Tracks({}), Tracks({})).raw_m));
  const MpjpeResult result = EvaluateMpjpe(Alone(), Standing("0@9"));
  EXPECT_TRUE(std::isnan(result.bias_removed_m));
  EXPECT_EQ(result.found.total, 1);
}

PersonPose Stated(Pose3d joints, const Eigen::Matrix3d& covariance) {
  PersonPose person = Person(0, std::move(joints));
  person.covariances.assign(person.joints.size(), covariance);
  return person;
}

TEST(ConsistencyTest, MatchesHandComputedValues) {
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

TEST(ConsistencyTest, MissingCovariancesDoNotCountAndNegativeOnesCoverNothing) {
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

TEST(ConsistencyTest, CorrectCovariancesHaveNominalCoverage) {
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
  // Four standard errors: of a coverage of 95 %, and of a mean of chi-square
  // values (variance 6) divided by 3.
  EXPECT_NEAR(row.stated.covered.fraction(), 0.95,
              4.0 * std::sqrt(0.95 * 0.05 / kCount));
  EXPECT_NEAR(row.stated.nees_per_dof, 1.0,
              4.0 * std::sqrt(6.0 / kCount) / 3.0);
}

}  // namespace
}  // namespace kinegraph::testing
