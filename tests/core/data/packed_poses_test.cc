#include "core/data/packed_poses.h"

#include <gtest/gtest.h>

namespace kinegraph {
namespace {

PersonPose FullPose() {
  PersonPose pose;
  pose.id = TrackId(7);
  pose.score = 0.1 + 0.2;  // no decimal fraction
  pose.joints.resize(3);
  pose.joints[1].position_m = {1.0, 2.0, 3.0};
  pose.joints[1].status = JointStatus::kObserved;
  pose.inlier_views = {0, 5, 300};
  Eigen::Matrix3d symmetric;
  symmetric << 1.1, 0.2, 0.3, 0.2, 2.2, 0.4, 0.3, 0.4, 3.3;
  Eigen::Matrix3d rounded = symmetric;
  rounded(2, 1) += 1e-16;  // by one bit
  pose.covariances = {symmetric, std::nullopt, rounded};
  pose.matches.resize(2);
  pose.matches[0] = {2, 11, {}};
  pose.matches[1] = {0, 4, {0.3, std::nullopt, 1.0}};
  return pose;
}

TEST(PackedPosesTest, EveryBitComesBack) {
  const PersonPose before = FullPose();
  ASSERT_NE((*before.covariances[2])(2, 1), (*before.covariances[2])(1, 2));
  PersonPose pose = before;
  PackedPoses packed;
  packed.Push(&pose);
  packed.RestoreFront(&pose);
  EXPECT_EQ(pose.id, before.id);
  EXPECT_EQ(pose.score, before.score);
  ASSERT_EQ(pose.joints.size(), before.joints.size());
  EXPECT_EQ(pose.joints[1].position_m, before.joints[1].position_m);
  EXPECT_EQ(pose.joints[1].status, before.joints[1].status);
  EXPECT_EQ(pose.inlier_views, before.inlier_views);
  EXPECT_EQ(pose.covariances, before.covariances);
  ASSERT_EQ(pose.matches.size(), before.matches.size());
  for (size_t m = 0; m < pose.matches.size(); ++m) {
    EXPECT_EQ(pose.matches[m].view_idx, before.matches[m].view_idx);
    EXPECT_EQ(pose.matches[m].detection_idx, before.matches[m].detection_idx);
    EXPECT_EQ(pose.matches[m].weights, before.matches[m].weights);
  }
}

TEST(PackedPosesTest, TheIdentityStays) {
  PersonPose pose = FullPose();
  PackedPoses packed;
  packed.Push(&pose);
  EXPECT_EQ(pose.id, TrackId(7));
  EXPECT_TRUE(pose.joints.empty());
  EXPECT_TRUE(pose.inlier_views.empty());
  EXPECT_TRUE(pose.covariances.empty());
  EXPECT_TRUE(pose.matches.empty());
}

TEST(PackedPosesTest, TheOldestComesFirst) {
  PackedPoses packed;
  PersonPose pose;
  for (const double score : {0.25, 0.5}) {
    pose.score = score;
    packed.Push(&pose);
  }
  packed.RestoreFront(&pose);
  EXPECT_EQ(pose.score, 0.25);
  packed.Pop();
  packed.RestoreFront(&pose);
  EXPECT_EQ(pose.score, 0.5);
  packed.Pop();
  EXPECT_TRUE(packed.empty());
}

TEST(PackedPosesTest, NothingKeptIsNothingRestored) {
  PersonPose pose;
  PackedPoses packed;
  packed.Push(&pose);
  packed.RestoreFront(&pose);
  EXPECT_EQ(pose.score, 0.0);
  EXPECT_TRUE(pose.joints.empty());
  EXPECT_TRUE(pose.inlier_views.empty());
  EXPECT_TRUE(pose.covariances.empty());
  EXPECT_TRUE(pose.matches.empty());
}

}  // namespace
}  // namespace kinegraph
