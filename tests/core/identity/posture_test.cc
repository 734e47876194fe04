#include "core/identity/posture.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "tests/core/identity/crowd.h"

namespace kinegraph {
namespace {

const Eigen::Vector3d kUp = Eigen::Vector3d::UnitZ();

// A standing person in one frame, with the right wrist (joint 10) raised by
// `raised_m`, rotated about the vertical axis of the world by `turn_rad`.
LimbPosture Raised(double raised_m, double turn_rad = 0.0) {
  testing::CrowdMaker crowd(1);
  crowd.Add({0, 0, 0, {1.0, 2.0}, {0.0, 0.0}, 1.0}, 0.0);
  std::vector<TrackFrame> frames = crowd.frames();
  Pose3d& joints = frames[0].people[0].joints;
  joints[10].position_m.z() += raised_m;
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(turn_rad, kUp).toRotationMatrix();
  for (Joint3d& joint : joints) joint.position_m = turn * joint.position_m;
  return PostureOf(CollectTracklets(frames, Coco17()).front(), 0);
}

TEST(PostureTest, DistanceMatchesHandComputedValues) {
  EXPECT_EQ(Raised(0.0).limbs_m.size(), 12u);
  // One of twelve joints, 0.6 m.
  EXPECT_NEAR(*PostureDistance(Raised(0.0), Raised(0.6), kUp),
              0.6 / std::sqrt(12.0), 1e-12);
  EXPECT_EQ(*PostureDistance(Raised(0.3), Raised(0.3), kUp), 0.0);
}

TEST(PostureTest, PositionAndHeadingDoNotCount) {
  // Sums of a few rotated coordinates of a few metres: 1e-15 each.
  EXPECT_NEAR(*PostureDistance(Raised(0.3), Raised(0.3, 2.0), kUp), 0.0, 1e-13);
  EXPECT_NEAR(*PostureDistance(Raised(0.3), Raised(0.3, 2.0), -kUp), 0.0,
              1e-13);
}

TEST(PostureTest, TooFewJointsAreNoPosture) {
  LimbPosture few = Raised(0.0);
  for (size_t i = 0; i < 5; ++i) few.limbs_m[i].setConstant(std::nan(""));
  EXPECT_FALSE(PostureDistance(few, Raised(0.0), kUp).has_value());
  EXPECT_FALSE(PostureDistance(LimbPosture(), Raised(0.0), kUp).has_value());
  const PostureModel model({}, kUp);
  EXPECT_EQ(model.LogRatio(LimbPosture(), Raised(0.0), 0.1), 0.0);
}

TEST(PostureTest, EvidenceDecaysWithTime) {
  const PostureModel model({}, kUp);
  // After 0.2 s a distance of 0.1 m is typical of one person; 0.4 m is more
  // typical of two, whose median distance is 0.28 m.
  const LimbPosture here = Raised(0.0);
  const LimbPosture own = Raised(0.1 * std::sqrt(12.0));
  const LimbPosture other = Raised(0.4 * std::sqrt(12.0));
  EXPECT_GT(model.LogRatio(here, own, 0.2), 1.0);
  EXPECT_LT(model.LogRatio(here, other, 0.2), -1.0);
  EXPECT_LT(model.LogRatio(here, own, 2.0), model.LogRatio(here, own, 0.2));
  EXPECT_GT(model.LogRatio(here, other, 2.0), model.LogRatio(here, other, 0.2));
  // After a minute the share of people who continue their activity is
  // 0.9 e^-20 = 2e-9.
  EXPECT_NEAR(model.LogRatio(here, other, 60.0), 0.0, 1e-6);
}

TEST(PostureTest, EqualPosturesGiveNoEvidence) {
  testing::CrowdMaker crowd(500);
  crowd.Add({0, 0, 499, {-2.0, 0.0}, {0.0, 0.0}, 1.0})
      .Add({1, 0, 499, {2.0, 0.0}, {0.0, 0.0}, 1.0});
  const PostureModel model(CollectTracklets(crowd.frames(), Coco17()), kUp);
  EXPECT_LT(model.strangers_m(), 0.05);
  EXPECT_NEAR(model.LogRatio(Raised(0.0), Raised(0.0), 0.2), 0.0, 1e-12);
}

}  // namespace
}  // namespace kinegraph
