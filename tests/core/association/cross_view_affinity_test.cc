// The affinity of Chen et al. (2020), worked by hand.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/association/affinity.h"
#include "tests/support/rig.h"

namespace kinegraph {
namespace {

class CrossViewAffinityTest : public ::testing::Test {
 protected:
  CrossViewAffinityTest() : camera_(Parameters()) {
    options_.affinity = AffinityKind::kCrossView;
    options_.alpha_2d_px_per_frame = 60.0;
    options_.alpha_3d_m = 0.15;
    options_.lambda_a_per_frame = 5.0;
    options_.min_common_joints = 0.0;
    // The pixel (370, 240) is the ray along (0.1, 0, 1).
    Keypoint joint;
    joint.px = {370.0, 240.0};
    joint.confidence = 1.0;
    joint.found = true;
    observation_.joints.assign(17, joint);
    observation_.ideal_px.assign(17, joint.px);
    // 6 cm above the ray: 1 - 0.06 / 0.15 = 0.6.
    Joint3d expected;
    expected.position_m = {0.5, 0.06, 5.0};
    expected.status = JointStatus::kObserved;
    expected_.assign(17, expected);
    // 12 px away: 1 - 12 / 60 = 0.8 after one frame.
    last_seen_.assign(17, {true, {370.0, 252.0}, 1.0});
  }

  static CameraParameters Parameters() {
    CameraParameters parameters;
    parameters.K << 500, 0, 320, 0, 500, 240, 0, 0, 1;
    return parameters;
  }

  double Affinity(double expected_age_frames) const {
    return CrossViewAffinity(observation_, last_seen_, expected_,
                             expected_age_frames, camera_,
                             Coco17().association_joints(), options_);
  }

  Camera camera_;
  AssociationOptions options_;
  Observation observation_;
  Pose3d expected_;
  std::vector<LastSeenJoint> last_seen_;
};

constexpr double kRounding = 1e-12;  // of sums of 34 terms of order one

TEST_F(CrossViewAffinityTest, SumsBothTermsOverTheJoints) {
  // 17 (0.4 * 0.8 + 0.6 * 0.6) e^-5.
  EXPECT_NEAR(Affinity(1.0), 17.0 * 0.68 * std::exp(-5.0), kRounding);
}

TEST_F(CrossViewAffinityTest, WhatThisFrameSawDecaysNot) {
  EXPECT_NEAR(Affinity(0.0), 17.0 * (0.32 * std::exp(-5.0) + 0.36), kRounding);
}

TEST_F(CrossViewAffinityTest, TheImageTermHasItsOwnAge) {
  // 12 px of 2 * 60 px.
  for (LastSeenJoint& joint : last_seen_) joint.age_frames = 2.0;
  EXPECT_NEAR(Affinity(1.0),
              17.0 * (0.4 * 0.9 * std::exp(-10.0) + 0.36 * std::exp(-5.0)),
              kRounding);
}

TEST_F(CrossViewAffinityTest, ATermWithoutItsJointIsZero) {
  last_seen_.clear();  // never matched in this view
  EXPECT_NEAR(Affinity(1.0), 17.0 * 0.36 * std::exp(-5.0), kRounding);
  for (int j = 1; j < 17; ++j) expected_[j].status = JointStatus::kMissing;
  EXPECT_NEAR(Affinity(1.0), 0.36 * std::exp(-5.0), kRounding);
  observation_.joints[0].found = false;
  EXPECT_EQ(Affinity(1.0), 0.0);
}

TEST_F(CrossViewAffinityTest, AnExpectedJointBehindTheCameraTakesNoPart) {
  last_seen_.clear();
  for (Joint3d& joint : expected_) joint.position_m *= -1.0;  // on the line
  EXPECT_EQ(Affinity(1.0), 0.0);
}

TEST_F(CrossViewAffinityTest, OneFarJointCanOutweighTheRest) {
  // The sum is not part-aware: 16 joints of 0.36 and one of
  // 0.6 (1 - 2.0 / 0.15) = -7.4.
  last_seen_.clear();
  expected_[0].position_m.y() = 2.0;
  EXPECT_NEAR(Affinity(0.0), 16.0 * 0.36 + 0.6 * (1.0 - 2.0 / 0.15), kRounding);
  EXPECT_LT(Affinity(0.0), 0.0);
}

TEST_F(CrossViewAffinityTest, TooFewJointsAreNoMatch) {
  options_.min_common_joints = 6.0;
  for (int j = 5; j < 17; ++j) observation_.joints[j].found = false;
  EXPECT_EQ(Affinity(1.0), 0.0);
  observation_.joints[5].found = true;
  EXPECT_GT(Affinity(1.0), 0.0);
}

TEST_F(CrossViewAffinityTest, TheProjectedTargetIsTheLastPoseInTheImage) {
  // (0.5, 0.06, 5) projects to (370, 246): 6 px away.
  options_.target_2d = Target2d::kProjected;
  const auto measure =
      MakeAffinityMeasure(options_, Coco17().association_joints());
  AssociationTarget target;
  target.pose = &expected_;
  target.age_frames = 1.0;
  measure->SetTarget(target, camera_);
  EXPECT_NEAR(measure->Of(observation_),
              17.0 * (0.4 * 0.9 + 0.36) * std::exp(-5.0), kRounding);
  // What is remembered does not matter then; what is expected does.
  target.last_seen = &last_seen_;
  Pose3d nearer = expected_;
  for (Joint3d& joint : nearer) joint.position_m.y() = 0.0;
  target.expected = &nearer;
  target.expected_age_frames = 0.0;
  measure->SetTarget(target, camera_);
  EXPECT_NEAR(measure->Of(observation_),
              17.0 * (0.4 * 0.9 * std::exp(-5.0) + 0.6), kRounding);
}

TEST_F(CrossViewAffinityTest, AViewMatcherUsesIt) {
  const CameraRig cameras = testing::RingOfCameras(1, 6.0);
  const Pose3d left = testing::StandingPerson(-1.0, 1.0);
  const Pose3d right = testing::StandingPerson(1.0, -1.0);
  const std::vector<Observation> seen = {testing::Observe(right, cameras, 0, 0),
                                         testing::Observe(left, cameras, 0, 1)};
  ViewMatcher matcher(options_, Coco17().association_joints());
  std::vector<int> match;
  matcher.Match({{&left, 1.0}, {&right, 1.0}}, seen, cameras[0], &match);
  EXPECT_EQ(match, (std::vector<int>{1, 0}));
  // Exact: every joint gives w3d e^-5, without a memory of this view.
  EXPECT_NEAR(matcher.affinities()[1], 17.0 * 0.6 * std::exp(-5.0), 1e-9);
}

}  // namespace
}  // namespace kinegraph
