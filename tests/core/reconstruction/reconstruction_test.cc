#include "core/reconstruction/reconstruction.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/support/rig.h"

namespace kinegraph {
namespace {

class ReconstructionTest : public ::testing::Test {
 protected:
  ReconstructionTest() {
    for (int v = 0; v < 4; ++v) {
      observations_.push_back(testing::Observe(person_, cameras_, v));
    }
  }

  std::vector<UsedView> Views(const std::vector<double>& ages_frames) const {
    std::vector<UsedView> views;
    for (size_t v = 0; v < ages_frames.size(); ++v) {
      views.push_back({&observations_[v], ages_frames[v]});
    }
    return views;
  }

  Reconstructor Make(const ReconstructionOptions& options = {}) const {
    return Reconstructor(cameras_, epipolar_, options, Coco17());
  }

  // Lets joint `j` be seen by `views` alone.
  void SeenBy(int j, const std::vector<int>& views) {
    for (Observation& observation : observations_) {
      observation.joints[j].found = false;
    }
    for (const int v : views) observations_[v].joints[j].found = true;
  }

  CameraRig cameras_ = testing::RingOfCameras(4);
  EpipolarGeometry epipolar_{cameras_};
  Pose3d person_ = testing::StandingPerson(0.2, -0.1);
  std::vector<Observation> observations_;
  Reconstruction out_;
};

TEST_F(ReconstructionTest, ExactViewsGiveThePose) {
  Reconstructor reconstructor = Make();
  ASSERT_TRUE(reconstructor.Update(Views({0, 0, 0, 0}), person_, &out_));
  for (int j = 0; j < 17; ++j) {
    EXPECT_EQ(out_.pose[j].status, JointStatus::kObserved);
    EXPECT_LT((out_.pose[j].position_m - person_[j].position_m).norm(), 1e-9);
    EXPECT_EQ(out_.fresh_inlier_views[j], 4);
  }
  EXPECT_EQ(out_.lost_joints, 0);
}

TEST_F(ReconstructionTest, OneViewFails) {
  Reconstructor reconstructor = Make();
  EXPECT_FALSE(reconstructor.Update(Views({0}), person_, &out_));
}

TEST_F(ReconstructionTest, AJointWithOneViewTakesThePrediction) {
  SeenBy(9, {2});
  Pose3d predicted = person_;
  predicted[9].position_m = {1, 2, 3};
  Reconstructor reconstructor = Make();
  ASSERT_TRUE(reconstructor.Update(Views({0, 0, 0, 0}), predicted, &out_));
  EXPECT_EQ(out_.pose[9].status, JointStatus::kInferred);
  EXPECT_EQ(out_.pose[9].position_m, Eigen::Vector3d(1, 2, 3));
  EXPECT_FALSE(out_.triangulated[9]);
  EXPECT_EQ(out_.fresh_inlier_views[9], 1);
}

TEST_F(ReconstructionTest, AJointNeverSeenIsMissing) {
  SeenBy(9, {});
  Pose3d predicted = person_;
  predicted[9].status = JointStatus::kMissing;
  Reconstructor reconstructor = Make();
  ASSERT_TRUE(reconstructor.Update(Views({0, 0, 0, 0}), predicted, &out_));
  EXPECT_EQ(out_.pose[9].status, JointStatus::kMissing);
}

TEST_F(ReconstructionTest, OldViewsCountOnlyWhenFreshOnesAreFew) {
  // The old view 2 saw the person 10 cm higher; 0 and 1 are at right angles.
  Pose3d higher = person_;
  for (Joint3d& joint : higher) joint.position_m.z() += 0.1;
  observations_[2] = testing::Observe(higher, cameras_, 2);
  ReconstructionOptions options;
  options.alpha_epi_px = 1000.0;  // no conflicts here
  Reconstructor reconstructor = Make(options);
  ASSERT_TRUE(reconstructor.Update(Views({0, 0, 1}), person_, &out_));
  // exp(-5 * 1 frame) in the equation, 4.5e-5 in its square: the pull is that
  // share of 10 cm at most.
  EXPECT_LT((out_.pose[0].position_m - person_[0].position_m).norm(), 4.6e-6);
  EXPECT_EQ(out_.pose[0].status, JointStatus::kObserved);
  EXPECT_EQ(out_.fresh_inlier_views[0], 2);

  ASSERT_TRUE(reconstructor.Update(Views({0, 1}), person_, &out_));
  EXPECT_TRUE(out_.triangulated[0]);
  EXPECT_EQ(out_.pose[0].status, JointStatus::kInferred)
      << "one view of this frame is no observation";
}

TEST_F(ReconstructionTest, SixLostJointsOfSeventeenFailFiveDoNot) {
  ReconstructionOptions options;
  options.lost = LostRule::kSeen;  // the paper's
  Reconstructor reconstructor = Make(options);
  for (int j = 0; j < 5; ++j) SeenBy(j, {0});
  EXPECT_TRUE(reconstructor.Update(Views({0, 0, 0, 0}), person_, &out_));
  EXPECT_EQ(out_.lost_joints, 5);
  SeenBy(5, {0});
  EXPECT_FALSE(reconstructor.Update(Views({0, 0, 0, 0}), person_, &out_));
  EXPECT_EQ(out_.lost_joints, 6);
  EXPECT_EQ(out_.seen_joints, 17);
}

// Two views that miss joints each for itself contradict each other in none.
TEST_F(ReconstructionTest, JointsOfOneViewAreNotLostInGraphMode) {
  Reconstructor reconstructor = Make();
  for (int j = 0; j < 12; ++j) SeenBy(j, {j % 2});
  EXPECT_TRUE(reconstructor.Update(Views({0, 0}), person_, &out_));
  EXPECT_EQ(out_.seen_joints, 17);
  EXPECT_EQ(out_.lost_joints, 12);
  EXPECT_EQ(out_.alone_joints, 12);
  // 4 of 17 are less than a quarter.
  SeenBy(12, {0});
  EXPECT_FALSE(reconstructor.Update(Views({0, 0}), person_, &out_));
}

TEST_F(ReconstructionTest, ContradictionsFailInGraphModeToo) {
  Reconstructor reconstructor = Make();
  for (int j = 0; j < 8; ++j) SeenBy(j, {j % 2});
  // Of the nine that two views measure three may contradict.
  const auto put_off = [&](int j) {
    observations_[1].joints[j].px.y() += 150.0;
    observations_[1].ideal_px[j].y() += 150.0;
  };
  for (int j = 8; j < 11; ++j) put_off(j);
  EXPECT_TRUE(reconstructor.Update(Views({0, 0}), person_, &out_));
  EXPECT_EQ(out_.lost_joints, 11);
  EXPECT_EQ(out_.alone_joints, 8);
  put_off(11);
  EXPECT_FALSE(reconstructor.Update(Views({0, 0}), person_, &out_));
}

TEST_F(ReconstructionTest, JointsNotSeenAtAllAreNotLost) {
  Reconstructor reconstructor = Make();
  for (int j = 0; j < 8; ++j) SeenBy(j, {});
  EXPECT_TRUE(reconstructor.Update(Views({0, 0, 0, 0}), person_, &out_));
  EXPECT_EQ(out_.seen_joints, 9);
  EXPECT_EQ(out_.lost_joints, 0);
}

TEST_F(ReconstructionTest, TheFilterRemovesAWrongView) {
  for (Keypoint& joint : observations_[3].joints) joint.px.y() += 150.0;
  for (Eigen::Vector2d& px : observations_[3].ideal_px) px.y() += 150.0;
  Reconstructor reconstructor = Make();
  ASSERT_TRUE(reconstructor.Update(Views({0, 0, 0, 0}), person_, &out_));
  EXPECT_LT((out_.pose[7].position_m - person_[7].position_m).norm(), 1e-9);
  EXPECT_EQ(out_.verdicts[3 * 17 + 7], FilterVerdict::kRemoved);
  EXPECT_EQ(out_.verdicts[0 * 17 + 7], FilterVerdict::kKept);

  ReconstructionOptions options;
  options.joints_filter = false;
  Reconstructor without = Make(options);
  ASSERT_TRUE(without.Update(Views({0, 0, 0, 0}), person_, &out_));
  EXPECT_GT((out_.pose[7].position_m - person_[7].position_m).norm(), 0.02);
}

TEST_F(ReconstructionTest, WithoutTheFilterZeroConfidenceDoesNotCount) {
  // A filled joint: a position with confidence 0, far off.
  observations_[2].joints[7].confidence = 0.0;
  observations_[2].ideal_px[7] += Eigen::Vector2d(200, 200);
  ReconstructionOptions options;
  options.joints_filter = false;
  Reconstructor reconstructor = Make(options);
  ASSERT_TRUE(reconstructor.Update(Views({0, 0, 0, 0}), person_, &out_));
  EXPECT_LT((out_.pose[7].position_m - person_[7].position_m).norm(), 1e-9);
}

TEST_F(ReconstructionTest, InitialisationHasNoPredictionToFallBackOn) {
  SeenBy(9, {2});
  Reconstructor reconstructor = Make();
  reconstructor.Initialise(Views({0, 0, 0, 0}), 60.0, &out_);
  EXPECT_EQ(out_.pose[9].status, JointStatus::kMissing);
  EXPECT_EQ(out_.pose[8].status, JointStatus::kObserved);
}

TEST_F(ReconstructionTest, OfOneViewTheNewestJointCounts) {
  // View 0 twice: its new pose lacks joint 9, its old one has it elsewhere for
  // every other joint.
  Observation older = observations_[0];
  for (int j = 0; j < 17; ++j) {
    if (j != 9) older.ideal_px[j].x() += 300.0;
  }
  observations_[0].joints[9].found = false;
  ReconstructionOptions options;
  options.joints_filter = false;
  options.newest = NewestRule::kJoint;
  Reconstructor reconstructor = Make(options);
  const std::vector<UsedView> views = {
      {&observations_[0], 0.0}, {&older, 1.0}, {&observations_[1], 0.0}};
  ASSERT_TRUE(reconstructor.Update(views, person_, &out_));
  for (int j = 0; j < 17; ++j) {
    EXPECT_LT((out_.pose[j].position_m - person_[j].position_m).norm(), 1e-9)
        << j;
    EXPECT_EQ(out_.fresh_inlier_views[j], j == 9 ? 1 : 2);
  }
}

TEST_F(ReconstructionTest, TwoPosesOfOneViewAreOneView) {
  ReconstructionOptions options;
  options.max_lost_share = 1.0;
  Reconstructor reconstructor = Make(options);
  EXPECT_FALSE(reconstructor.Update(
      std::vector<UsedView>{{&observations_[0], 0.0}, {&observations_[0], 1.0}},
      person_, &out_));
}

}  // namespace
}  // namespace kinegraph
