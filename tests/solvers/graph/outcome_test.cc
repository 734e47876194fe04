// Poses written from chains that are built by hand. Statuses and the removal of
// uncertain joints are tested in assembler_test.cc.
#include "solvers/graph/outcome.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace kinegraph {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

PixelMeasurement Weighted(int16_t view_slot, double weight,
                          bool gated = false) {
  PixelMeasurement measurement;
  measurement.view_slot = view_slot;
  measurement.weight = weight;
  measurement.gated = gated;
  return measurement;
}

// Three frames with three, no and two views.
JointChain ThreeFrames() {
  JointChain chain;
  for (const double x_m : {1.0, 2.0, 3.0}) {
    State state;
    state << x_m, -x_m, 0.5, 9.0, 9.0, 9.0;
    chain.states.push_back(state);
  }
  chain.measurements = {Weighted(0, 0.9), Weighted(1, 0.5),
                        Weighted(2, 0.8, true), Weighted(0, 0.2),
                        Weighted(2, 1.0)};
  chain.first = {0, 3, 3, 5};
  return chain;
}

FrameRecord RecordOfViews(const std::vector<int>& views) {
  FrameRecord record;
  record.frame = 12;
  record.time = 480000000;
  record.score = 0.7;
  for (const int v : views) record.views.push_back({v, 10 + v});
  return record;
}

TEST(Outcome, InliersAreUngatedViewsOfEnoughWeight) {
  const JointChain chain = ThreeFrames();
  // A weight equal to the limit suffices.
  EXPECT_EQ(CountInliers(chain, 0, 0.5), 2);
  EXPECT_EQ(CountInliers(chain, 0, 0.51), 1);
  EXPECT_EQ(CountInliers(chain, 0, 0.0), 2);
  EXPECT_EQ(CountInliers(chain, 1, 0.0), 0);
  EXPECT_EQ(CountInliers(chain, 2, 0.5), 1);
  EXPECT_EQ(CountInliers(chain, 2, 0.1), 2);
}

SceneModel SceneOf(int joints, KeptMatches kept) {
  SceneModel scene;
  scene.skeleton = Skeleton("some",
                            joints == 1 ? std::vector<std::string>{"a"}
                                        : std::vector<std::string>{"a", "b"},
                            {});
  scene.kept_matches = kept;
  return scene;
}

TEST(Outcome, PoseOfCopiesTheFrameRecord) {
  const FinalPose pose =
      PoseOf(RecordOfViews({3, 0}), SceneOf(2, KeptMatches::kWeights), true);
  EXPECT_EQ(pose.frame, 12);
  EXPECT_EQ(pose.time, 480000000);
  EXPECT_EQ(pose.person.score, 0.7);
  ASSERT_EQ(pose.person.joints.size(), 2u);
  EXPECT_EQ(CountPresent(pose.person.joints), 0);
  EXPECT_THAT(pose.person.inlier_views, ElementsAre(0, 0));
  ASSERT_EQ(pose.person.covariances.size(), 2u);
  EXPECT_FALSE(pose.person.covariances[0].has_value());
  ASSERT_EQ(pose.person.matches.size(), 2u);
  EXPECT_EQ(pose.person.matches[0].view_idx, 3);
  EXPECT_EQ(pose.person.matches[0].detection_idx, 13);
  EXPECT_EQ(pose.person.matches[1].view_idx, 0);
  EXPECT_EQ(pose.person.matches[1].detection_idx, 10);
  for (const ViewMatch& match : pose.person.matches) {
    EXPECT_THAT(match.weights, ElementsAre(std::nullopt, std::nullopt));
  }
}

TEST(Outcome, PoseOfKeepsOnlyRequestedMatches) {
  const FrameRecord record = RecordOfViews({3, 0});
  const FinalPose detections =
      PoseOf(record, SceneOf(2, KeptMatches::kDetections), false);
  EXPECT_THAT(detections.person.covariances, IsEmpty());
  ASSERT_EQ(detections.person.matches.size(), 2u);
  EXPECT_THAT(detections.person.matches[0].weights, IsEmpty());
  const FinalPose none = PoseOf(record, SceneOf(2, KeptMatches::kNone), false);
  EXPECT_THAT(none.person.matches, IsEmpty());
  EXPECT_EQ(none.person.joints.size(), 2u);
  EXPECT_THAT(PoseOf(RecordOfViews({}), SceneOf(2, KeptMatches::kWeights), true)
                  .person.matches,
              IsEmpty());
}

TEST(Outcome, WriteJointSetsPositionCovarianceAndWeights) {
  PersonPose pose =
      PoseOf(RecordOfViews({5, 6, 7}), SceneOf(2, KeptMatches::kWeights), true)
          .person;
  const Eigen::Matrix3d covariance =
      Eigen::Vector3d(1e-4, 4e-4, 9e-4).asDiagonal();
  WriteJoint(ThreeFrames(), 0, 1, JointStatus::kObserved, 2, &covariance,
             &pose);
  EXPECT_EQ(pose.joints[1].status, JointStatus::kObserved);
  EXPECT_EQ(pose.joints[1].position_m, Eigen::Vector3d(1.0, -1.0, 0.5));
  EXPECT_THAT(pose.inlier_views, ElementsAre(0, 2));
  ASSERT_TRUE(pose.covariances[1].has_value());
  EXPECT_EQ(*pose.covariances[1], covariance);
  // Gated views have weight zero.
  EXPECT_EQ(pose.matches[0].weights[1], 0.9);
  EXPECT_EQ(pose.matches[1].weights[1], 0.5);
  EXPECT_EQ(pose.matches[2].weights[1], 0.0);
  // The other joint is untouched.
  EXPECT_FALSE(pose.joints[0].present());
  EXPECT_FALSE(pose.covariances[0].has_value());
  for (const ViewMatch& match : pose.matches) {
    EXPECT_FALSE(match.weights[0].has_value());
  }
}

// Weights are assigned to views by slot; a view that did not measure the joint
// has none.
TEST(Outcome, WriteJointUsesTheWeightsOfTheGivenFrame) {
  PersonPose pose =
      PoseOf(RecordOfViews({5, 6, 7}), SceneOf(1, KeptMatches::kWeights), false)
          .person;
  WriteJoint(ThreeFrames(), 2, 0, JointStatus::kInferred, 1, nullptr, &pose);
  EXPECT_EQ(pose.joints[0].position_m, Eigen::Vector3d(3.0, -3.0, 0.5));
  EXPECT_EQ(pose.matches[0].weights[0], 0.2);
  EXPECT_FALSE(pose.matches[1].weights[0].has_value());
  EXPECT_EQ(pose.matches[2].weights[0], 1.0);
}

TEST(Outcome, MissingJointHasNoPositionOrCovariance) {
  PersonPose pose =
      PoseOf(RecordOfViews({5, 6, 7}), SceneOf(1, KeptMatches::kWeights), true)
          .person;
  const Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
  WriteJoint(ThreeFrames(), 0, 0, JointStatus::kMissing, 1, &covariance, &pose);
  EXPECT_FALSE(pose.joints[0].present());
  EXPECT_EQ(pose.joints[0].position_m, Eigen::Vector3d(0.0, 0.0, 0.0));
  EXPECT_FALSE(pose.covariances[0].has_value());
  // The weights of its views are written nevertheless.
  EXPECT_THAT(pose.inlier_views, ElementsAre(1));
  EXPECT_EQ(pose.matches[0].weights[0], 0.9);
}

TEST(Outcome, WriteJointWritesNoWeightsUnlessTheyAreKept) {
  for (const KeptMatches kept :
       {KeptMatches::kNone, KeptMatches::kDetections}) {
    PersonPose pose =
        PoseOf(RecordOfViews({5, 6, 7}), SceneOf(1, kept), false).person;
    WriteJoint(ThreeFrames(), 0, 0, JointStatus::kObserved, 2, nullptr, &pose);
    EXPECT_TRUE(pose.joints[0].present());
    for (const ViewMatch& match : pose.matches) {
      EXPECT_THAT(match.weights, IsEmpty());
    }
  }
}

TEST(Outcome, DerivativeIsTheVelocityOfTheState) {
  SceneModel scene = SceneOf(2, KeptMatches::kNone);
  PersonPose pose = PoseOf(RecordOfViews({}), scene, false).person;
  WriteJoint(ThreeFrames(), 1, 1, JointStatus::kObserved, 2, nullptr, &pose);
  EXPECT_THAT(pose.derivatives, IsEmpty());
  scene.keep_derivatives = true;
  pose = PoseOf(RecordOfViews({}), scene, false).person;
  JointChain chain = ThreeFrames();
  chain.states[1].tail<3>() << 0.5, -1.0, 2.0;
  WriteJoint(chain, 1, 1, JointStatus::kObserved, 2, nullptr, &pose);
  EXPECT_FALSE(pose.derivatives[0].has_value());
  ASSERT_TRUE(pose.derivatives[1].has_value());
  EXPECT_EQ(pose.derivatives[1]->velocity_m_s, Eigen::Vector3d(0.5, -1.0, 2.0));
  EXPECT_FALSE(pose.derivatives[1]->acceleration_m_s2.has_value());
}

}  // namespace
}  // namespace kinegraph
