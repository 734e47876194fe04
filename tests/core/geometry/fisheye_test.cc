#include <gtest/gtest.h>

#include <cmath>

#include "core/geometry/camera.h"

namespace kinegraph {
namespace {

// As a GoPro's wide view has them.
const std::vector<double> kTerms = {-0.02, 0.015, -0.01, 0.002};
constexpr double kRightAngle = 1.57079632679489662;

Camera FisheyeCamera(const std::vector<double>& terms = kTerms) {
  CameraParameters p;
  p.width_px = 1920;
  p.height_px = 1440;
  p.K << 600, 0, 960, 0, 610, 720, 0, 0, 1;
  p.lens = MakeLens(kFisheyeModel, terms);
  return Camera(p);
}

// The formula of OpenCV's documentation (cv::fisheye), by itself.
Eigen::Vector2d ByTheBook(const Camera& camera, const Eigen::Vector3d& point) {
  const std::vector<double> k = camera.lens()->parameters();
  const double a = point.x() / point.z();
  const double b = point.y() / point.z();
  const double r = std::sqrt(a * a + b * b);
  const double t = std::atan(r);
  const double td = t + k[0] * std::pow(t, 3) + k[1] * std::pow(t, 5) +
                    k[2] * std::pow(t, 7) + k[3] * std::pow(t, 9);
  const Eigen::Matrix3d& K = camera.K();
  return {K(0, 0) * td / r * a + K(0, 2), K(1, 1) * td / r * b + K(1, 2)};
}

// A ray so far off the axis, in some direction about it.
Eigen::Vector3d RayAt(double angle, double about) {
  return {std::sin(angle) * std::cos(about), std::sin(angle) * std::sin(about),
          std::cos(angle)};
}

TEST(Fisheye, ProjectsByTheBook) {
  const Camera camera = FisheyeCamera();
  for (double angle = 0.01; angle < kRightAngle; angle += 0.05) {
    const Eigen::Vector3d point = 3.0 * RayAt(angle, 7.0 * angle);
    const auto px = camera.Project(point);
    ASSERT_TRUE(px.has_value()) << angle;
    EXPECT_LT((*px - ByTheBook(camera, point)).norm(), 1e-9) << angle;
  }
  EXPECT_EQ(*camera.Project({0, 0, 2}), Eigen::Vector2d(960, 720));
  // Nothing but zeros bends, too: it is no pinhole.
  EXPECT_NEAR(FisheyeCamera({}).Project({1, 0, 1})->x(),
              960 + 600 * kRightAngle / 2, 1e-9);
}

TEST(Fisheye, UndistortIsTheInverse) {
  for (const auto& terms : {kTerms, std::vector<double>{},
                            std::vector<double>{0.3, -0.1, 0.05, 0.01}}) {
    const Camera camera = FisheyeCamera(terms);
    for (double angle = 0.0; angle < kRightAngle - 1e-3; angle += 0.013) {
      const Eigen::Vector3d ray = RayAt(angle, 5.0 * angle);
      const auto ideal = camera.Undistort(*camera.Project(ray));
      ASSERT_TRUE(ideal.has_value()) << angle;
      // Rounding of the pixel, 1e-13 px of 600, is an angle; the ray's own
      // direction is what must come back, as tan grows without bound. A
      // thousand times that rounding.
      EXPECT_LT((camera.RayDirection(*ideal) - ray).norm(), 1e-12) << angle;
    }
  }
}

TEST(Fisheye, WhatIsNotInFrontHasNoImage) {
  const Camera camera = FisheyeCamera({});
  EXPECT_FALSE(camera.Project({1, 0, 0}).has_value()) << "at the side";
  EXPECT_FALSE(camera.Project({1, 0, -0.1}).has_value()) << "behind";
  EXPECT_TRUE(camera.Project({1, 0, 1e-6}).has_value());
  // 90 degrees lie at 600 px * pi / 2 = 942 px from the middle.
  EXPECT_TRUE(camera.Undistort({960 + 942.0, 720}).has_value());
  EXPECT_FALSE(camera.Undistort({960 + 943.0, 720}).has_value());
}

TEST(Fisheye, BeyondTheFoldNothingIsSeen) {
  // d(a - 0.3 a^3)/da = 0 at a = 1.054, whose image is 0.703.
  const Camera camera = FisheyeCamera({-0.3});
  EXPECT_TRUE(camera.Project(RayAt(1.05, 0.0)).has_value());
  EXPECT_FALSE(camera.Project(RayAt(1.06, 0.0)).has_value());
  EXPECT_TRUE(camera.Undistort({960 + 600 * 0.702, 720}).has_value());
  EXPECT_FALSE(camera.Undistort({960 + 600 * 0.704, 720}).has_value());
}

// The SIMD kernels do what a single point does, bit for bit.
TEST(Fisheye, PacksEqualSinglePoints) {
  const Camera camera = FisheyeCamera();
  const double points[2][3] = {{1.5, -0.3, 1.0}, {1e-7, 2e-7, 2.0}};
  BaselinePack point[3];
  for (int i = 0; i < 3; ++i) {
    const double both[2] = {points[0][i], points[1][i]};
    point[i] = BaselinePack::Load(both);
  }
  BaselinePack u;
  BaselinePack v;
  BaselinePack jacobian[6];
  EXPECT_TRUE(All(Project(camera.model(), point, &u, &v, jacobian)));
  for (int lane = 0; lane < 2; ++lane) {
    double px[2];
    double by_rows[6];
    ASSERT_TRUE(Project(camera.model(), points[lane], &px[0], &px[1], by_rows));
    EXPECT_EQ(u[lane], px[0]);
    EXPECT_EQ(v[lane], px[1]);
    for (int i = 0; i < 6; ++i) EXPECT_EQ(jacobian[i][lane], by_rows[i]);
  }
}

TEST(Fisheye, TheFirstRadialTermIsTheDerivativeByK1) {
  const Eigen::Vector2d ideal(0.8, -1.1);
  for (const auto& lens : {MakeLens(kFisheyeModel, kTerms),
                           MakeLens("opencv5", {0.1, 0.02, 1e-3, 1e-3})}) {
    Eigen::Matrix2d before;
    Eigen::Matrix2d after;
    Eigen::Matrix2d jacobian;
    const Eigen::Vector2d moved =
        WithRadial(lens, 0.25)->Distort(ideal, &after) -
        lens->Distort(ideal, &before);
    const double factor = FirstRadialFactor(lens.get(), ideal, &jacobian);
    // Linear in k1: equal to rounding.
    EXPECT_LT((moved - 0.25 * factor * ideal).norm(), 1e-14);
    EXPECT_LT((after - before - 0.25 * jacobian).norm(), 1e-13);
  }
  EXPECT_EQ(WithRadial(nullptr, 0.1)->model(), "opencv5");
  // A turned image keeps the terms of a lens that is round.
  const auto lens = MakeLens(kFisheyeModel, kTerms);
  EXPECT_EQ(Turned(lens, ImageTurn::kClockwise)->parameters(), kTerms);
}

}  // namespace
}  // namespace kinegraph
