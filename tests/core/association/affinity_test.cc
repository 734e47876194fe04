#include "core/association/affinity.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/support/rig.h"

namespace kinegraph {
namespace {

std::vector<int> AllJoints() { return Coco17().association_joints(); }

// A projected pose with every joint at the origin of the image.
ProjectedPose AtOrigin(int joints = 17) {
  ProjectedPose projected;
  projected.px.assign(joints, Eigen::Vector2d::Zero());
  projected.valid.assign(joints, 1);
  return projected;
}

// An observation whose joint j lies distances[j] px to the right of it.
Observation AtDistances(const std::vector<double>& distances_px) {
  Observation observation;
  for (const double d : distances_px) {
    Keypoint joint;
    joint.px = {d, 0.0};
    joint.confidence = 1.0;
    joint.found = true;
    observation.joints.push_back(joint);
  }
  return observation;
}

AssociationOptions Options() {
  AssociationOptions options;
  options.alpha_2d_px_per_frame = 70.0;
  options.lambda_a_per_frame = 3.0;
  options.epsilon_joints = 11.0;
  return options;
}

TEST(AffinityTest, MeanOverPositiveJointsByHand) {
  // Eleven joints at 35 px (g = 0.5), six far away.
  std::vector<double> distances(17, 35.0);
  for (int j = 11; j < 17; ++j) distances[j] = 500.0;
  EXPECT_DOUBLE_EQ(
      Affinity(AtDistances(distances), AtOrigin(), 1.0, AllJoints(), Options()),
      0.5 * std::exp(-3.0));
}

TEST(AffinityTest, FewerThanEpsilonIsNoMatch) {
  std::vector<double> distances(17, 35.0);
  for (int j = 10; j < 17; ++j) distances[j] = 500.0;
  EXPECT_EQ(
      Affinity(AtDistances(distances), AtOrigin(), 1.0, AllJoints(), Options()),
      0.0);
}

TEST(AffinityTest, ADistanceOfExactlyAlphaIsNotPositive) {
  std::vector<double> distances(17, 0.0);
  for (int j = 10; j < 17; ++j) distances[j] = 70.0;
  EXPECT_EQ(
      Affinity(AtDistances(distances), AtOrigin(), 1.0, AllJoints(), Options()),
      0.0);
}

TEST(AffinityTest, TheGateGrowsWithTheAgeAndLambdaOnlyScales) {
  const std::vector<double> distances(17, 105.0);
  const Observation observation = AtDistances(distances);
  EXPECT_EQ(Affinity(observation, AtOrigin(), 1.0, AllJoints(), Options()),
            0.0);
  // 105 px of 2 * 70 px leave a quarter.
  EXPECT_DOUBLE_EQ(
      Affinity(observation, AtOrigin(), 2.0, AllJoints(), Options()),
      0.25 * std::exp(-6.0));
  AssociationOptions mild = Options();
  mild.lambda_a_per_frame = 0.0;
  EXPECT_DOUBLE_EQ(Affinity(observation, AtOrigin(), 2.0, AllJoints(), mild),
                   0.25);
}

TEST(AffinityTest, MissingJointsTakeNoPart) {
  // Nine joints are common: ceil(11 / 17 * 9) = 6 must be positive.
  std::vector<double> distances(17, 35.0);
  for (int j = 6; j < 17; ++j) distances[j] = 500.0;
  Observation observation = AtDistances(distances);
  for (int j = 9; j < 17; ++j) observation.joints[j].found = false;
  EXPECT_DOUBLE_EQ(
      Affinity(observation, AtOrigin(), 1.0, AllJoints(), Options()),
      0.5 * std::exp(-3.0));
  observation.joints[5].px.x() = 500.0;  // five positive of nine
  EXPECT_EQ(Affinity(observation, AtOrigin(), 1.0, AllJoints(), Options()),
            0.0);
}

TEST(AffinityTest, TooFewCommonJointsAreNoMatch) {
  Observation observation = AtDistances(std::vector<double>(17, 0.0));
  for (int j = 5; j < 17; ++j) observation.joints[j].found = false;
  EXPECT_EQ(Affinity(observation, AtOrigin(), 1.0, AllJoints(), Options()),
            0.0);
}

TEST(AffinityTest, BodyAwareIsTheMeanOverAllJoints) {
  AssociationOptions options = Options();
  options.affinity = AffinityKind::kBody;
  std::vector<double> distances(17, 0.0);
  distances[0] = 70.0 * 18.0;  // g = -17: the mean is (16 - 17) / 17
  EXPECT_NEAR(
      Affinity(AtDistances(distances), AtOrigin(), 1.0, AllJoints(), options),
      -1.0 / 17.0 * std::exp(-3.0), 1e-16);
}

class ViewMatcherTest : public ::testing::Test {
 protected:
  CameraRig cameras_ = testing::RingOfCameras(1, 6.0);
  ViewMatcher matcher_{Options(), AllJoints()};
};

TEST_F(ViewMatcherTest, GivesEachPersonTheirDetection) {
  const Pose3d left = testing::StandingPerson(-1.0, 1.0);
  const Pose3d right = testing::StandingPerson(1.0, -1.0);
  const std::vector<Observation> seen = {
      testing::Observe(right, cameras_, 0, 0),
      testing::Observe(left, cameras_, 0, 1)};
  std::vector<int> match;
  matcher_.Match({{&left, 1.0}, {&right, 1.0}}, seen, cameras_[0], &match);
  EXPECT_EQ(match, (std::vector<int>{1, 0}));
}

TEST_F(ViewMatcherTest, AFaintAffinityIsStillAMatch) {
  // Ten missed frames: the factor is e^-30 = 1e-13, and it must count.
  const Pose3d pose = testing::StandingPerson(0.0, 0.0);
  const std::vector<Observation> seen = {testing::Observe(pose, cameras_, 0)};
  std::vector<int> match;
  matcher_.Match({{&pose, 10.0}}, seen, cameras_[0], &match);
  EXPECT_LT(matcher_.affinities()[0], 1e-12);
  EXPECT_EQ(match, (std::vector<int>{0}));
}

TEST_F(ViewMatcherTest, AFreshTrackGoesBeforeAStaleOne) {
  const Pose3d pose = testing::StandingPerson(0.0, 0.0);
  const std::vector<Observation> seen = {testing::Observe(pose, cameras_, 0)};
  std::vector<int> match;
  matcher_.Match({{&pose, 4.0}, {&pose, 1.0}}, seen, cameras_[0], &match);
  EXPECT_EQ(match, (std::vector<int>{-1, 0}));
}

TEST_F(ViewMatcherTest, NobodyAndNothing) {
  const Pose3d pose = testing::StandingPerson(0.0, 0.0);
  std::vector<int> match;
  matcher_.Match({}, {}, cameras_[0], &match);
  EXPECT_TRUE(match.empty());
  matcher_.Match({{&pose, 1.0}}, {}, cameras_[0], &match);
  EXPECT_EQ(match, (std::vector<int>{-1}));
}

TEST_F(ViewMatcherTest, APersonBehindTheCameraMatchesNothing) {
  const Pose3d pose = testing::StandingPerson(0.0, 0.0);
  const Pose3d behind = testing::StandingPerson(40.0, 0.0);
  const std::vector<Observation> seen = {testing::Observe(pose, cameras_, 0)};
  std::vector<int> match;
  matcher_.Match({{&behind, 1.0}}, seen, cameras_[0], &match);
  EXPECT_EQ(match, (std::vector<int>{-1}));
}

// A camera at the origin that looks along z with a focal length of 1000 px.
Camera FrontalCamera() {
  CameraParameters parameters;
  parameters.K << 1000.0, 0.0, 500.0, 0.0, 1000.0, 500.0, 0.0, 0.0, 1.0;
  return Camera(parameters);
}

TEST(GateTest, ThePapersGateGrowsWithEveryFrame) {
  const Pose3d pose(17, {{0.0, 0.0, 5.0}, JointStatus::kObserved});
  AssociationOptions options;
  EXPECT_EQ(GatePx(pose, 1.0, FrontalCamera(), options), 70.0);
  EXPECT_EQ(GatePx(pose, 10.0, FrontalCamera(), options), 700.0);
  EXPECT_EQ(GatePx(pose, 0.1, FrontalCamera(), options), 7.0);
}

// Half a millisecond after the last frame a detector errs no less.
TEST(GateTest, FramesOffTheBeatDoNotNarrowIt) {
  const Pose3d pose(17, {{0.0, 0.0, 5.0}, JointStatus::kObserved});
  AssociationOptions options;
  options.reach_m_per_frame = 0.125;
  EXPECT_EQ(GatePx(pose, 0.1, FrontalCamera(), options), 70.0);
}

TEST(GateTest, ALostPersonIsLookedForWhereTheyMayHaveGone) {
  const Pose3d pose(17, {{0.0, 0.0, 5.0}, JointStatus::kObserved});
  AssociationOptions options;
  options.reach_m_per_frame = 0.125;
  // As the paper's in the next frame, then 0.125 m, 25 px at 5 m, a frame.
  EXPECT_EQ(GatePx(pose, 1.0, FrontalCamera(), options), 70.0);
  EXPECT_EQ(GatePx(pose, 9.0, FrontalCamera(), options), 270.0);
  // Never more than the paper's: 1 m away, 125 px a frame.
  const Pose3d near(17, {{0.0, 0.0, 1.0}, JointStatus::kObserved});
  EXPECT_EQ(GatePx(near, 9.0, FrontalCamera(), options), 630.0);
}

}  // namespace
}  // namespace kinegraph
