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

  // Updates with the first ages_frames.size() views, each of the given age
  // [frames], and with the prediction predicted_.
  bool Update(const std::vector<double>& ages_frames) {
    std::vector<UsedView> views;
    for (size_t v = 0; v < ages_frames.size(); ++v) {
      views.push_back({&observations_[v], ages_frames[v]});
    }
    return UpdateFrom(views);
  }
  bool UpdateFrom(const std::vector<UsedView>& views) {
    return Reconstructor(cameras_, epipolar_, options_, Coco17())
        .Update(views, predicted_, &out_);
  }
  bool UpdateFromAll() { return Update({0, 0, 0, 0}); }

  double ErrorOf(int j) const {
    return (out_.pose[j].position_m - person_[j].position_m).norm();
  }

  // Moves one joint of a view down, or all joints.
  void Lower(int view, double by_px, int joint = -1) {
    for (int j = 0; j < 17; ++j) {
      if (joint >= 0 && j != joint) continue;
      observations_[view].joints[j].px.y() += by_px;
      observations_[view].ideal_px[j].y() += by_px;
    }
  }

  // Restricts joint `j` to `views`.
  void SeenBy(int j, const std::vector<int>& views) {
    for (Observation& observation : observations_) {
      observation.joints[j].found = false;
    }
    for (const int v : views) observations_[v].joints[j].found = true;
  }

  CameraRig cameras_ = testing::RingOfCameras(4);
  EpipolarGeometry epipolar_{cameras_};
  Pose3d person_ = testing::StandingPerson(0.2, -0.1);
  Pose3d predicted_ = person_;
  std::vector<Observation> observations_;
  ReconstructionOptions options_;
  Reconstruction out_;
};

TEST_F(ReconstructionTest, ExactViewsGiveThePoseAndOneViewFails) {
  ASSERT_TRUE(UpdateFromAll());
  for (int j = 0; j < 17; ++j) {
    EXPECT_EQ(out_.pose[j].status, JointStatus::kObserved);
    EXPECT_LT(ErrorOf(j), 1e-9);
    EXPECT_EQ(out_.fresh_inlier_views[j], 4);
  }
  EXPECT_EQ(out_.lost_joints, 0);
  EXPECT_FALSE(Update({0}));
  // Two poses of one view are one view.
  options_.max_lost_share = 1.0;
  EXPECT_FALSE(
      UpdateFrom({{&observations_[0], 0.0}, {&observations_[0], 1.0}}));
}

TEST_F(ReconstructionTest, AJointWithOneViewTakesThePrediction) {
  SeenBy(9, {2});
  predicted_[9].position_m = {1, 2, 3};
  ASSERT_TRUE(UpdateFromAll());
  EXPECT_EQ(out_.pose[9].status, JointStatus::kInferred);
  EXPECT_EQ(out_.pose[9].position_m, Eigen::Vector3d(1, 2, 3));
  EXPECT_FALSE(out_.triangulated[9]);
  EXPECT_EQ(out_.fresh_inlier_views[9], 1);
  // A joint that was never seen is missing.
  SeenBy(9, {});
  predicted_[9].status = JointStatus::kMissing;
  ASSERT_TRUE(UpdateFromAll());
  EXPECT_EQ(out_.pose[9].status, JointStatus::kMissing);
}

TEST_F(ReconstructionTest, OldViewsMatterOnlyWithoutTwoFreshViews) {
  // The old view 2 saw the person 10 cm higher; 0 and 1 are at right angles.
  Pose3d higher = person_;
  for (Joint3d& joint : higher) joint.position_m.z() += 0.1;
  observations_[2] = testing::Observe(higher, cameras_, 2);
  options_.alpha_epi_px = 1000.0;  // no conflicts here
  ASSERT_TRUE(Update({0, 0, 1}));
  // The weight is exp(-5 * 1 frame), its square 4.5e-5: the error is at most
  // that fraction of 10 cm.
  EXPECT_LT(ErrorOf(0), 4.6e-6);
  EXPECT_EQ(out_.pose[0].status, JointStatus::kObserved);
  EXPECT_EQ(out_.fresh_inlier_views[0], 2);

  ASSERT_TRUE(Update({0, 1}));
  EXPECT_TRUE(out_.triangulated[0]);
  EXPECT_EQ(out_.pose[0].status, JointStatus::kInferred)
      << "kObserved requires two views of this frame";
}

TEST_F(ReconstructionTest, SixLostJointsOfSeventeenFailFiveDoNot) {
  options_.lost = LostRule::kSeen;  // the paper's
  for (int j = 0; j < 5; ++j) SeenBy(j, {0});
  EXPECT_TRUE(UpdateFromAll());
  EXPECT_EQ(out_.lost_joints, 5);
  SeenBy(5, {0});
  EXPECT_FALSE(UpdateFromAll());
  EXPECT_EQ(out_.lost_joints, 6);
  EXPECT_EQ(out_.seen_joints, 17);
}

// Joints that only one of two views measures are no contradictions
// (LostRule::kContradicted, the default).
TEST_F(ReconstructionTest,
       JointsOfOneViewFailTheUpdateOnlyIfUnderAQuarterRemain) {
  for (int j = 0; j < 12; ++j) SeenBy(j, {j % 2});
  EXPECT_TRUE(Update({0, 0}));
  EXPECT_EQ(out_.seen_joints, 17);
  EXPECT_EQ(out_.lost_joints, 12);
  EXPECT_EQ(out_.alone_joints, 12);
  // Now both views measure only 4 of the 17 joints, less than the required
  // quarter.
  SeenBy(12, {0});
  EXPECT_FALSE(Update({0, 0}));
}

TEST_F(ReconstructionTest, MoreThanAThirdContradictedFailsTheUpdate) {
  for (int j = 0; j < 8; ++j) SeenBy(j, {j % 2});
  // Up to max_lost_share = 1/3 of the nine joints measured by two views may be
  // contradictory.
  for (int j = 8; j < 11; ++j) Lower(1, 150.0, j);
  EXPECT_TRUE(Update({0, 0}));
  EXPECT_EQ(out_.lost_joints, 11);
  EXPECT_EQ(out_.alone_joints, 8);
  Lower(1, 150.0, 11);
  EXPECT_FALSE(Update({0, 0}));
}

TEST_F(ReconstructionTest, JointsNotSeenAtAllAreNotLost) {
  for (int j = 0; j < 8; ++j) SeenBy(j, {});
  EXPECT_TRUE(UpdateFromAll());
  EXPECT_EQ(out_.seen_joints, 9);
  EXPECT_EQ(out_.lost_joints, 0);
}

TEST_F(ReconstructionTest, TheFilterRemovesAWrongView) {
  Lower(3, 150.0);
  ASSERT_TRUE(UpdateFromAll());
  EXPECT_LT(ErrorOf(7), 1e-9);
  EXPECT_EQ(out_.verdicts[3 * 17 + 7], FilterVerdict::kRemoved);
  EXPECT_EQ(out_.verdicts[0 * 17 + 7], FilterVerdict::kKept);
  options_.joints_filter = false;
  ASSERT_TRUE(UpdateFromAll());
  EXPECT_GT(ErrorOf(7), 0.02);
}

TEST_F(ReconstructionTest, ZeroConfidenceDoesNotCountWithoutTheFilter) {
  // A filled joint: a position with confidence 0, far off.
  observations_[2].joints[7].confidence = 0.0;
  observations_[2].ideal_px[7] += Eigen::Vector2d(200, 200);
  options_.joints_filter = false;
  ASSERT_TRUE(UpdateFromAll());
  EXPECT_LT(ErrorOf(7), 1e-9);
}

TEST_F(ReconstructionTest, InitialisationHasNoPredictionToFallBackOn) {
  SeenBy(9, {2});
  std::vector<UsedView> views;
  for (const Observation& seen : observations_) views.push_back({&seen, 0.0});
  Reconstructor(cameras_, epipolar_, options_, Coco17())
      .Initialise(views, 60.0, &out_);
  EXPECT_EQ(out_.pose[9].status, JointStatus::kMissing);
  EXPECT_EQ(out_.pose[8].status, JointStatus::kObserved);
}

TEST_F(ReconstructionTest, NewestJointOfAViewCounts) {
  // View 0 appears twice: its newer pose lacks joint 9, its older pose has all
  // other joints displaced.
  Observation older = observations_[0];
  for (int j = 0; j < 17; ++j) {
    if (j != 9) older.ideal_px[j].x() += 300.0;
  }
  observations_[0].joints[9].found = false;
  options_.joints_filter = false;
  options_.newest = NewestRule::kJoint;
  ASSERT_TRUE(UpdateFrom(
      {{&observations_[0], 0.0}, {&older, 1.0}, {&observations_[1], 0.0}}));
  for (int j = 0; j < 17; ++j) {
    EXPECT_LT(ErrorOf(j), 1e-9) << j;
    EXPECT_EQ(out_.fresh_inlier_views[j], j == 9 ? 1 : 2);
  }
}

class JointsFilterTest : public ::testing::Test {
 protected:
  using Kept = std::vector<char>;

  // Rays to `point_` in the first views, moved by `offsets_px`.
  std::vector<JointRay> Rays(const std::vector<Eigen::Vector2d>& offsets_px) {
    std::vector<JointRay> rays;
    for (size_t v = 0; v < offsets_px.size(); ++v) {
      const auto px = cameras_[v].Project(point_);
      rays.push_back({static_cast<int>(v), *px + offsets_px[v]});
    }
    return rays;
  }

  Kept Apply(const std::vector<JointRay>& rays,
             const Eigen::Vector3d* predicted,
             ConflictOrder order = ConflictOrder::kView,
             double alpha_px = 20.0) {
    const EpipolarGeometry epipolar(cameras_);
    Kept kept;
    JointsFilter(cameras_, epipolar)
        .Apply(rays, alpha_px, order, predicted, &kept);
    return kept;
  }

  // Cameras that look along z, at these positions along x.
  void StandInARow(const std::vector<double>& places_m) {
    CameraParameters p;
    p.K << 500, 0, 320, 0, 500, 240, 0, 0, 1;
    cameras_.clear();
    for (const double x_m : places_m) {
      p.t.x() = -x_m;
      cameras_.emplace_back(p);
    }
  }

  CameraRig cameras_ = testing::RingOfCameras(5);
  Eigen::Vector3d point_{0.2, 0.1, 1.3};
};

TEST_F(JointsFilterTest, RemovesTheOutlier) {
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
  // Views 0 and 2 agree on another point; the prediction agrees with view 1.
  const Eigen::Vector3d elsewhere(0.2, 0.1, 1.9);
  auto rays = Rays({{0, 0}, {0, 0}, {0, 0}});
  rays[0].ideal_px = *cameras_[0].Project(elsewhere);
  rays[2].ideal_px = *cameras_[2].Project(elsewhere);
  EXPECT_EQ(Apply(rays, &point_), (Kept{0, 1, 0}));
  EXPECT_EQ(Apply(rays, nullptr), (Kept{1, 0, 1}));
}

TEST_F(JointsFilterTest, TiesRemoveSecondRayWithPredictionElseFirst) {
  // The prediction is midway between two skew rays, so it is equally far from
  // both.
  StandInARow({-0.5, 0.5});
  const std::vector<JointRay> rays = {{0, {320, 290}}, {1, {320, 190}}};
  const Eigen::Vector3d midway(0, 0, 4);
  EXPECT_EQ(Apply(rays, &midway), (Kept{1, 0}));
  EXPECT_EQ(Apply(rays, nullptr), (Kept{0, 1}));
}

TEST_F(JointsFilterTest, OrderOfConflictsMatters) {
  // View 0 contradicts view 1 slightly and view 2 strongly; the prediction is
  // nearest to ray 2, then to ray 0, then to ray 1. By view order, view 1 is
  // removed first and then view 0; worst first, view 0 is removed and view 1
  // is kept.
  auto rays = Rays({{0, 45}, {0, 0}, {0, -30}});
  const EpipolarGeometry epipolar(cameras_);
  const auto distance_px = [&](int a, int b) {
    return epipolar.Distance(a, rays[a].ideal_px, b, rays[b].ideal_px);
  };
  const double e01 = distance_px(0, 1), e02 = distance_px(0, 2),
               e12 = distance_px(1, 2);
  ASSERT_GT(e02, e01);
  ASSERT_GT(e01, e12);
  const double alpha_px = 0.5 * (e01 + e12);  // 0-1 and 0-2 are in conflict
  // A prediction whose distances d from the rays satisfy d2 < d0 < d1.
  Eigen::Vector3d predicted = point_;
  bool found = false;
  for (double up = -0.4; up < 0.4 && !found; up += 0.005) {
    for (double side = -0.4; side < 0.4 && !found; side += 0.02) {
      predicted = point_ + Eigen::Vector3d(side, 0.0, up);
      const auto from_ray = [&](int v) {
        return DistanceToRay(cameras_[v], rays[v].ideal_px, predicted);
      };
      found = from_ray(2) < from_ray(0) && from_ray(0) < from_ray(1);
    }
  }
  ASSERT_TRUE(found) << "no prediction with that order of distances";
  EXPECT_EQ(Apply(rays, &predicted, ConflictOrder::kView, alpha_px),
            (Kept{0, 0, 1}));
  EXPECT_EQ(Apply(rays, &predicted, ConflictOrder::kWorstFirst, alpha_px),
            (Kept{0, 1, 1}));
}

TEST_F(JointsFilterTest, RowSumsIncludeRemovedViews) {
  // View 0 contradicts all others and is removed first; it still contributes
  // to the sums that decide between views 1 and 2.
  StandInARow({0.0, 0.5, 1.0, 1.5});
  // For parallel cameras side by side the epipolar distance is the difference
  // of the v coordinates, here 360, 240, 265 and 250; with alpha = 20,
  // E = 1 - |dv| / 20. The sum of E over all views is -5 + 1 - .25 + .5 = -3.75
  // for view 1 and -3.75 - .25 + 1 + .25 = -2.75 for view 2, so view 1 is
  // removed. Without view 0 the sums would be 1.25 and 1.0, and view 2 would be
  // removed.
  const std::vector<JointRay> rays = {
      {0, {320, 360}}, {1, {320, 240}}, {2, {320, 265}}, {3, {320, 250}}};
  EXPECT_EQ(Apply(rays, nullptr), (Kept{0, 0, 1, 1}));
}

}  // namespace
}  // namespace kinegraph
