// Counting and averaging the joints of a pose.
#include "core/data/pose.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

#include "core/base/constants.h"
#include "tests/support/rig.h"

namespace kinegraph {
namespace {

Joint3d At(const Eigen::Vector3d& position_m,
           JointStatus status = JointStatus::kObserved) {
  return {position_m, status};
}

TEST(JointStatus, HasANameAndIsPresentUnlessMissing) {
  EXPECT_STREQ(ToString(JointStatus::kObserved), "observed");
  EXPECT_STREQ(ToString(JointStatus::kInferred), "inferred");
  EXPECT_STREQ(ToString(JointStatus::kMissing), "missing");
  EXPECT_TRUE(At(Eigen::Vector3d::Zero(), JointStatus::kObserved).present());
  EXPECT_TRUE(At(Eigen::Vector3d::Zero(), JointStatus::kInferred).present());
  EXPECT_FALSE(Joint3d().present());
}

TEST(Pose, CountsPresentJoints) {
  EXPECT_EQ(CountPresent({}), 0);
  EXPECT_EQ(CountPresent(Pose3d(17)), 0);
  EXPECT_EQ(CountPresent({At({1.0, 2.0, 3.0}), Joint3d(),
                          At({1.0, 2.0, 3.0}, JointStatus::kInferred)}),
            2);
}

TEST(Pose, HasNoMeanWithoutPositions) {
  EXPECT_FALSE(MeanPosition({}).has_value());
  EXPECT_FALSE(MeanPosition(Pose3d(17)).has_value());
  EXPECT_FALSE(MeanPosition({At({1.0, kNan, 2.0})}).has_value());
  EXPECT_FALSE(
      MeanPosition({At({1.0, std::numeric_limits<double>::infinity(), 2.0})})
          .has_value());
}

TEST(Pose, MeanUsesPresentFiniteJoints) {
  const Pose3d pose = {
      At({1.0, -2.0, 3.0}), At({100.0, 100.0, 100.0}, JointStatus::kMissing),
      At({kNan, 0.0, 0.0}), At({3.0, 4.0, -1.0}, JointStatus::kInferred)};
  EXPECT_EQ(MeanPosition(pose), Eigen::Vector3d(2.0, 1.0, 1.0));
  EXPECT_EQ(MeanPosition({pose.front()}), pose.front().position_m);
}

// The mean of moved joints is the moved mean, in any order. Sums of 17 numbers
// of about 1 m have rounding errors of 17 * 1e-16 m.
TEST(Pose, MeanTransformsWithThePose) {
  const Pose3d pose = testing::StandingPerson(0.4, -0.3);
  const Eigen::Isometry3d motion =
      Eigen::Translation3d(0.5, -0.7, 0.2) *
      Eigen::AngleAxisd(1.1, Eigen::Vector3d(1.0, 2.0, -1.0).normalized());
  Pose3d moved = pose;
  for (Joint3d& joint : moved) joint.position_m = motion * joint.position_m;
  std::reverse(moved.begin(), moved.end());
  EXPECT_LT((*MeanPosition(moved) - motion * *MeanPosition(pose)).norm(),
            1e-14);
}

}  // namespace
}  // namespace kinegraph
