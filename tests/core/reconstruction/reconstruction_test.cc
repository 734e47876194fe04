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

class JointsFilterTest : public ::testing::Test {
 protected:
  // Rays to `point_` in the given views, moved by `offset_px` where one is
  // given.
  std::vector<JointRay> Rays(const std::vector<Eigen::Vector2d>& offsets_px) {
    std::vector<JointRay> rays;
    for (size_t v = 0; v < offsets_px.size(); ++v) {
      const auto px = cameras_[v].Project(point_);
      rays.push_back({static_cast<int>(v), *px + offsets_px[v]});
    }
    return rays;
  }

  std::vector<char> Apply(const std::vector<JointRay>& rays,
                          const Eigen::Vector3d* predicted,
                          ConflictOrder order = ConflictOrder::kView,
                          double alpha_px = 20.0) {
    std::vector<char> kept;
    filter_.Apply(rays, alpha_px, order, predicted, &kept);
    return kept;
  }

  CameraRig cameras_ = testing::RingOfCameras(5);
  EpipolarGeometry epipolar_{cameras_};
  JointsFilter filter_{cameras_, epipolar_};
  Eigen::Vector3d point_{0.2, 0.1, 1.3};
};

TEST_F(JointsFilterTest, TheOutlierGoes) {
  using Kept = std::vector<char>;
  struct Case {
    std::vector<Eigen::Vector2d> offsets_px;
    bool predicted;
    Kept kept;
  };
  for (const Case& one :
       {Case{{{0, 0}, {0, 0}, {0, 0}, {0, 0}}, false, {1, 1, 1, 1}},
        {{{0, 0}, {0, 120}, {0, 0}}, true, {1, 0, 1}},
        {{{0, 0}, {0, 120}, {0, 0}}, false, {1, 0, 1}},  // by its row sum
        {{{0, 0}, {0, 200}}, true, {1, 0}},
        // Once the first is gone nothing else is in conflict.
        {{{0, 200}, {0, 0}, {0, 0}, {0, 0}}, true, {0, 1, 1, 1}},
        {{{0, 0}}, true, {1}},
        {{}, true, {}}}) {
    EXPECT_EQ(Apply(Rays(one.offsets_px), one.predicted ? &point_ : nullptr),
              one.kept);
  }
}

TEST_F(JointsFilterTest, ThePredictionDecidesEvenAgainstTheMajority) {
  // Views 0 and 2 agree on another point; the prediction sides with view 1.
  const Eigen::Vector3d elsewhere(0.2, 0.1, 1.9);
  auto rays = Rays({{0, 0}, {0, 0}, {0, 0}});
  rays[0].ideal_px = *cameras_[0].Project(elsewhere);
  rays[2].ideal_px = *cameras_[2].Project(elsewhere);
  EXPECT_EQ(Apply(rays, &point_), (std::vector<char>{0, 1, 0}));
  EXPECT_EQ(Apply(rays, nullptr), (std::vector<char>{1, 0, 1}));
}

TEST_F(JointsFilterTest, TiesSecondGoesWithAPredictionFirstWithout) {
  // Both rays of one and the same camera position cannot conflict, so make the
  // tie by symmetry: the prediction stands midway between two crossing rays.
  CameraParameters left;
  left.K << 500, 0, 320, 0, 500, 240, 0, 0, 1;
  left.t.x() = 0.5;
  CameraParameters right = left;
  right.t.x() = -0.5;
  const CameraRig pair = {Camera(left), Camera(right)};
  const EpipolarGeometry epipolar(pair);
  JointsFilter filter(pair, epipolar);
  const std::vector<JointRay> rays = {{0, {320, 290}}, {1, {320, 190}}};
  const Eigen::Vector3d midway(0, 0, 4);
  std::vector<char> kept;
  filter.Apply(rays, 20.0, ConflictOrder::kView, &midway, &kept);
  EXPECT_EQ(kept, (std::vector<char>{1, 0}));
  filter.Apply(rays, 20.0, ConflictOrder::kView, nullptr, &kept);
  EXPECT_EQ(kept, (std::vector<char>{0, 1}));
}

TEST_F(JointsFilterTest, OrderOfConflictsMatters) {
  // View 0 contradicts view 1 a little and view 2 much, seen from a prediction
  // that is nearer to 0 than to 1 but not than to 2. By view order 1 goes
  // first and then 0; worst first, 0 goes and 1 is innocent.
  auto rays = Rays({{0, 45}, {0, 0}, {0, -30}});
  const double e01 =
      epipolar_.Distance(0, rays[0].ideal_px, 1, rays[1].ideal_px);
  const double e02 =
      epipolar_.Distance(0, rays[0].ideal_px, 2, rays[2].ideal_px);
  const double e12 =
      epipolar_.Distance(1, rays[1].ideal_px, 2, rays[2].ideal_px);
  ASSERT_GT(e02, e01);
  ASSERT_GT(e01, e12);
  const double alpha_px = 0.5 * (e01 + e12);  // 0-1 and 0-2 are in conflict
  // A prediction whose distance from the rays is 2 < 0 < 1.
  Eigen::Vector3d predicted = point_;
  bool found = false;
  for (double up = -0.4; up < 0.4 && !found; up += 0.005) {
    for (double side = -0.4; side < 0.4 && !found; side += 0.02) {
      predicted = point_ + Eigen::Vector3d(side, 0.0, up);
      const double d0 = DistanceToRay(cameras_[0], rays[0].ideal_px, predicted);
      const double d1 = DistanceToRay(cameras_[1], rays[1].ideal_px, predicted);
      const double d2 = DistanceToRay(cameras_[2], rays[2].ideal_px, predicted);
      found = d2 < d0 && d0 < d1;
    }
  }
  ASSERT_TRUE(found) << "no prediction with that order of distances";
  EXPECT_EQ(Apply(rays, &predicted, ConflictOrder::kView, alpha_px),
            (std::vector<char>{0, 0, 1}));
  EXPECT_EQ(Apply(rays, &predicted, ConflictOrder::kWorstFirst, alpha_px),
            (std::vector<char>{0, 1, 1}));
}

TEST_F(JointsFilterTest, RowSumsCountViewsThatAreGoneAlready) {
  // View 0 is far from everything and goes first; its column still weighs in
  // the sums that decide view 1 against view 2.
  CameraParameters p;
  p.K << 500, 0, 320, 0, 500, 240, 0, 0, 1;
  CameraRig row;
  for (int i = 0; i < 4; ++i) {
    p.t.x() = -0.5 * i;
    row.emplace_back(p);
  }
  const EpipolarGeometry epipolar(row);
  JointsFilter filter(row, epipolar);
  // In a row of parallel cameras the distance is the difference of rows.
  // Rows 360, 240, 265, 250 and alpha 20, so E of a pair is 1 - difference
  // / 20. Sums over all views: 1: -5 + 1 - .25 + .5 = -3.75; 2: -3.75 - .25 + 1
  // + .25 = -2.75: view 1 goes. Without view 0 they would be 1.25 and 1.0, and
  // view 2 would go.
  const std::vector<JointRay> rays = {
      {0, {320, 360}}, {1, {320, 240}}, {2, {320, 265}}, {3, {320, 250}}};
  std::vector<char> kept;
  filter.Apply(rays, 20.0, ConflictOrder::kView, nullptr, &kept);
  EXPECT_EQ(kept, (std::vector<char>{0, 0, 1, 1}));
}

}  // namespace
}  // namespace kinegraph
