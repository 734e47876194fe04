#include "solvers/filters/robust_triangulation.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "core/base/random.h"
#include "core/geometry/triangulation.h"
#include "tests/support/rig.h"

namespace kinegraph {
namespace {

const Eigen::Vector3d kPoint(0.3, -0.2, 1.1);

std::vector<PixelPoint> See(const CameraRig& cameras, double sigma_px,
                            Random* random) {
  std::vector<PixelPoint> views;
  for (const Camera& camera : cameras) {
    Eigen::Vector2d px = *camera.Project(kPoint);
    if (random != nullptr) {
      for (double& coordinate : px) coordinate += random->Normal(0.0, sigma_px);
    }
    views.push_back({&camera, px, sigma_px});
  }
  return views;
}

TEST(RobustTriangulationTest, ExactPixelsGiveTheExactPoint) {
  // Raw pixels through a lens. The last step is below 1e-6 m and the steps
  // shrink quadratically; rounding of 1e-13 px at 5 m is far less.
  const CameraRig cameras =
      testing::RingOfCameras(4, 5.0, {-0.2, 0.05, 1e-3, -1e-3, 0.0});
  const RobustTriangulator triangulator({});
  const auto point = triangulator.Triangulate(See(cameras, 5.0, nullptr));
  ASSERT_TRUE(point.has_value());
  EXPECT_LT((point->position_m - kPoint).norm(), 1e-7);
  EXPECT_EQ(point->inlier_views, 4);
  for (const double weight : point->weights) EXPECT_NEAR(weight, 1.0, 1e-9);
}

TEST(RobustTriangulationTest, IsLeastSquaresWithoutLoss) {
  // At the least-squares point the gradient vanishes: sum J' r / sigma^2 = 0.
  const CameraRig cameras = testing::RingOfCameras(4);
  Random random(3);
  RobustTriangulationOptions options;
  options.loss = LossKind::kNone;
  const auto views = See(cameras, 5.0, &random);
  const auto point = RobustTriangulator(options).Triangulate(views);
  ASSERT_TRUE(point.has_value());
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  for (const PixelPoint& view : views) {
    Matrix23d J;
    const Eigen::Vector2d r =
        *view.camera->Project(point->position_m, &J) - view.px;
    gradient += J.transpose() * r / 25.0;
    normal += J.transpose() * J / 25.0;
  }
  // The gradient that remains at a distance of 1e-7 m from the minimum.
  EXPECT_LT(gradient.norm(), 1e-7 * normal.norm());
  EXPECT_TRUE(point->covariance_m2.isApprox(normal.inverse(), 1e-9));
}

TEST(RobustTriangulationTest, ResistsOneWrongViewOfThreeOrFive) {
  for (const int count : {3, 5}) {
    const CameraRig cameras = testing::RingOfCameras(count);
    for (size_t wrong = 0; wrong < cameras.size(); ++wrong) {
      auto views = See(cameras, 3.0, nullptr);
      views[wrong].px += Eigen::Vector2d(90.0, -60.0);
      const auto point = RobustTriangulator({}).Triangulate(views);
      ASSERT_TRUE(point.has_value());
      // The error of 108 px is 36 sigmas. The weight of the wrong view is thus
      // (9 / (9 + 36^2))^2 = 5e-5, which leaves an effect of 5e-5 * 108 px, 30
      // micrometres at 5 m and 1000 px.
      EXPECT_LT((point->position_m - kPoint).norm(), 1e-3)
          << count << " views, wrong " << wrong;
      EXPECT_LT(point->weights[wrong], 0.01);
      EXPECT_EQ(point->inlier_views, count - 1);
    }
  }
}

TEST(RobustTriangulationTest, FailsWithoutParallaxOrAgreement) {
  const CameraRig cameras = testing::RingOfCameras(4);
  const RobustTriangulator triangulator({});
  auto views = See(cameras, 3.0, nullptr);
  EXPECT_FALSE(triangulator.Triangulate({}).has_value());
  EXPECT_FALSE(triangulator.Triangulate({views[0]}).has_value());
  // The same camera twice: no parallax.
  EXPECT_FALSE(triangulator.Triangulate({views[0], views[0]}).has_value());
  // Two views that contradict each other by hundreds of sigmas.
  views[1].px.y() += 900.0;
  EXPECT_FALSE(triangulator.Triangulate({views[0], views[1]}).has_value());
  views[1].px.setConstant(std::numeric_limits<double>::quiet_NaN());
  const auto rest = triangulator.Triangulate(views);
  EXPECT_TRUE(!rest.has_value() || rest->position_m.allFinite());
}

// Mean normalised estimation error squared, divided by 3, of 2000 noisy points.
double MeanNees(const RobustTriangulationOptions& options, int view_count,
                bool from_dlt) {
  const CameraRig cameras = testing::RingOfCameras(view_count);
  const RobustTriangulator triangulator(options);
  Random random(11);
  double sum = 0.0;
  constexpr int kCount = 2000;
  for (int i = 0; i < kCount; ++i) {
    const auto views = See(cameras, 4.0, &random);
    const auto point = triangulator.Triangulate(views);
    Eigen::Vector3d error = point->position_m - kPoint;
    Eigen::Matrix3d covariance = point->covariance_m2;
    if (from_dlt) {
      std::vector<PointMeasurement> measurements;
      for (const PixelPoint& view : views) {
        measurements.push_back({view.camera, view.px, 1.0});
      }
      const Eigen::Vector3d dlt = TriangulateDlt(measurements).point_m;
      error = dlt - kPoint;
      covariance = *TriangulationCovariance(views, dlt);
    }
    sum += error.dot(covariance.ldlt().solve(error)) / 3.0;
  }
  return sum / kCount;
}

TEST(RobustTriangulationTest, CovariancesMatchTheErrors) {
  // For 2000 draws of 3 degrees of freedom the standard error is sqrt(2 / 6000)
  // = 0.018.
  RobustTriangulationOptions least_squares;
  least_squares.loss = LossKind::kNone;
  for (const int views : {2, 3, 5}) {
    EXPECT_NEAR(MeanNees(least_squares, views, false), 1.0, 0.08) << views;
    // DLT with normalised rows weights views like least squares only at equal
    // distances: a deviation of up to a tenth.
    EXPECT_NEAR(MeanNees({}, views, true), 1.0, 0.12) << views;
    // Random errors reduce the weights of good views, so covariances may be too
    // large, but not too small.
    const double robust = MeanNees({}, views, false);
    EXPECT_LT(robust, 1.0) << views;
    EXPECT_GT(robust, 0.85) << views;
  }
}

}  // namespace
}  // namespace kinegraph
