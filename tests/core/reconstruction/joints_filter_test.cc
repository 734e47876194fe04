#include <gtest/gtest.h>

#include <vector>

#include "core/reconstruction/reconstruction.h"
#include "tests/support/rig.h"

namespace kinegraph {
namespace {

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

TEST_F(JointsFilterTest, AgreeingViewsAllStay) {
  EXPECT_EQ(Apply(Rays({{0, 0}, {0, 0}, {0, 0}, {0, 0}}), nullptr),
            (std::vector<char>{1, 1, 1, 1}));
}

TEST_F(JointsFilterTest, TheOutlierGoesWithAPrediction) {
  const auto rays = Rays({{0, 0}, {0, 120}, {0, 0}});
  EXPECT_EQ(Apply(rays, &point_), (std::vector<char>{1, 0, 1}));
}

TEST_F(JointsFilterTest, TheOutlierGoesByItsRowSumAtInitialisation) {
  const auto rays = Rays({{0, 0}, {0, 120}, {0, 0}});
  EXPECT_EQ(Apply(rays, nullptr), (std::vector<char>{1, 0, 1}));
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

TEST_F(JointsFilterTest, TwoContradictingViewsLeaveOne) {
  const auto rays = Rays({{0, 0}, {0, 200}});
  EXPECT_EQ(Apply(rays, &point_), (std::vector<char>{1, 0}));
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

TEST_F(JointsFilterTest, APairWithAViewGoneIsPassedOver) {
  // View 0 is wrong against all; once it is gone nothing else is in conflict.
  const auto rays = Rays({{0, 200}, {0, 0}, {0, 0}, {0, 0}});
  EXPECT_EQ(Apply(rays, &point_), (std::vector<char>{0, 1, 1, 1}));
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

TEST_F(JointsFilterTest, OneViewOrNone) {
  EXPECT_EQ(Apply(Rays({{0, 0}}), &point_), (std::vector<char>{1}));
  EXPECT_TRUE(Apply({}, &point_).empty());
}

}  // namespace
}  // namespace kinegraph
