#include "solvers/rig/two_views.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "core/base/random.h"

namespace kinegraph {
namespace {

RelativePose Truth() {
  RelativePose pose;
  pose.R = Eigen::AngleAxisd(1.2, Eigen::Vector3d(0.1, 1.0, -0.2).normalized())
               .toRotationMatrix();
  pose.t = Eigen::Vector3d(-0.7, 0.1, 0.6).normalized();
  return pose;
}

// Points about one baseline away in front of both views, for focal lengths that
// are `magnification` times the assumed values, with noise in normalised
// coordinates.
std::vector<PointPair> Points(const RelativePose& pose, int count,
                              double magnification, double noise) {
  Random random(3);
  std::vector<PointPair> pairs;
  while (static_cast<int>(pairs.size()) < count) {
    const Eigen::Vector3d a(random.Uniform(-0.5, 0.5),
                            random.Uniform(-0.5, 0.5),
                            random.Uniform(0.6, 1.6));
    const Eigen::Vector3d b = pose.R * a + pose.t;
    if (b.z() < 0.2) continue;
    PointPair pair;
    pair.a = magnification * a.hnormalized();
    pair.b = magnification * b.hnormalized();
    for (int i = 0; i < 2; ++i) {
      pair.a[i] += random.Normal(0.0, noise);
      pair.b[i] += random.Normal(0.0, noise);
    }
    pairs.push_back(pair);
  }
  return pairs;
}

double AngleBetween(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return Eigen::AngleAxisd(Eigen::Matrix3d(a.transpose() * b)).angle();
}

TEST(TwoViews, EightPointRecoversThePoseFromExactPoints) {
  const RelativePose truth = Truth();
  for (const double magnification : {1.0, 1.3}) {
    const auto pose =
        EightPoint(Points(truth, 20, magnification, 0.0), magnification);
    ASSERT_TRUE(pose.has_value());
    // The eigenvector has a rounding error of 2e-12, double precision times a
    // condition number of 1e4; the rest is margin.
    EXPECT_LT(AngleBetween(pose->R, truth.R), 1e-9);
    EXPECT_LT((pose->t - truth.t).norm(), 1e-9);
  }
}

TEST(TwoViews, CoplanarPointsDoNotDetermineThePose) {
  const RelativePose truth = Truth();
  std::vector<PointPair> pairs = Points(truth, 20, 1.0, 0.0);
  Random random(5);
  for (PointPair& pair : pairs) {
    const Eigen::Vector3d a(random.Uniform(-0.3, 0.3),
                            random.Uniform(-0.3, 0.3), 1.0);
    pair.a = a.hnormalized();
    pair.b = (truth.R * a + truth.t).hnormalized();
  }
  EXPECT_FALSE(EightPoint(pairs, 1.0).has_value());
}

TEST(TwoViews, RefinementConvergesWithinTheNoise) {
  const RelativePose truth = Truth();
  const double noise = 0.003;
  const std::vector<PointPair> pairs = Points(truth, 400, 1.0, noise);
  RelativePose start = truth;
  start.R = Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitX()) * truth.R;
  const RelativePose pose = RefinePose(pairs, start, 0.01, 0.0);
  // Less than the noise of a single point.
  EXPECT_LT(AngleBetween(pose.R, truth.R), noise);
  EXPECT_LE(RobustCost(pairs, pose, 0.01), RobustCost(pairs, truth, 0.01));
}

TEST(TwoViews, RefinementRecoversTheMagnification) {
  const RelativePose truth = Truth();
  const std::vector<PointPair> pairs = Points(truth, 400, 1.1, 0.0);
  const RelativePose pose = RefinePose(pairs, truth, 0.01, 0.3);
  // The prior of 30 % biases the result of 400 exact points only slightly.
  EXPECT_NEAR(pose.magnification, 1.1, 0.002);
}

TEST(TwoViews, PoseWithPointsInFrontIsChosen) {
  const RelativePose truth = Truth();
  RelativePose mirrored = truth;
  mirrored.t = -truth.t;
  const RelativePose pose =
      WithMostInFront(Points(truth, 30, 1.0, 0.0), mirrored);
  EXPECT_LT((pose.t - truth.t).norm(), 1e-9);
  EXPECT_LT(AngleBetween(pose.R, truth.R), 1e-9);
}

TEST(TwoViews, DepthsMatchThePoint) {
  const RelativePose truth = Truth();
  const Eigen::Vector3d a(0.1, -0.2, 1.1);
  const Eigen::Vector3d b = truth.R * a + truth.t;
  PointPair pair;
  pair.a = a.hnormalized();
  pair.b = b.hnormalized();
  const auto depths = DepthsOf(truth, pair);
  ASSERT_TRUE(depths.has_value());
  EXPECT_NEAR((*depths)[0], a.z(), 1e-12);
  EXPECT_NEAR((*depths)[1], b.z(), 1e-12);
}

}  // namespace
}  // namespace kinegraph
