#include "core/geometry/camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/base/random.h"
#include "tests/support/rig.h"

namespace kinegraph {
namespace {

// A wide-angle lens: at the corner of the image (r^2 about 1.2) it moves points
// by more than a hundred pixels.
const std::vector<double> kWideLens = {-0.25, 0.08, 0.001, -0.0005, -0.01};
// Typical of a GoPro's wide field of view.
const std::vector<double> kFisheyeTerms = {-0.02, 0.015, -0.01, 0.002};

TEST(CameraTest, ProjectionMatchesHandComputedValues) {
  CameraParameters p;
  p.K << 100, 0, 50, 0, 200, 60, 0, 0, 1;
  p.t << 0, 0, 4;
  const Camera camera(p);
  // (1, 2, 0) stands 4 m away: x/z = 0.25, y/z = 0.5.
  const auto px = camera.Project({1, 2, 0});
  ASSERT_TRUE(px.has_value());
  EXPECT_DOUBLE_EQ(px->x(), 75.0);
  EXPECT_DOUBLE_EQ(px->y(), 160.0);
  EXPECT_DOUBLE_EQ(camera.centre().z(), -4.0);
  EXPECT_FALSE(camera.Project({0, 0, -4}).has_value()) << "at the centre";
  EXPECT_FALSE(camera.Project({0, 0, -5}).has_value()) << "behind";
}

TEST(CameraTest, DistortionMatchesHandComputedValues) {
  CameraParameters p;
  p.lens = MakeLens("opencv5", {0.1, 0.01, 0.001, 0.002, 0.0});
  const Camera camera(p);
  // x = 0.5, y = 0.2: r2 = 0.29, radial = 1 + 0.029 + 0.000841 = 1.029841.
  const auto px = camera.Project({0.5, 0.2, 1.0});
  ASSERT_TRUE(px.has_value());
  EXPECT_NEAR(px->x(), 0.5 * 1.029841 + 2 * 0.001 * 0.1 + 0.002 * (0.29 + 0.5),
              1e-15);
  EXPECT_NEAR(px->y(), 0.2 * 1.029841 + 0.001 * (0.29 + 0.08) + 2 * 0.002 * 0.1,
              1e-15);
}

TEST(CameraTest, UndistortReturnsTheIdealPixel) {
  const CameraRig bent = testing::RingOfCameras(4, 5.0, kWideLens);
  const CameraRig straight = testing::RingOfCameras(4);
  Random random(3);
  for (int round = 0; round < 500; ++round) {
    const Eigen::Vector3d point(random.Uniform(-1.5, 1.5),
                                random.Uniform(-1.5, 1.5),
                                random.Uniform(0.0, 2.0));
    const int view = round % 4;
    const auto raw = bent[view].Project(point);
    const auto ideal = straight[view].Project(point);
    ASSERT_TRUE(raw.has_value());
    const auto undistorted = bent[view].Undistort(*raw);
    ASSERT_TRUE(undistorted.has_value());
    // Newton stops at 1e-13 of normalised units, times 1000 px.
    EXPECT_LT((*undistorted - *ideal).norm(), 1e-9);
  }
}

TEST(CameraTest, JacobianEqualsDifferences) {
  Random random(4);
  // Lateral range of points 1 to 3 m in front of the camera.
  for (const auto& [lens, wide_m] :
       {std::pair{MakeLens("pinhole", {}), 0.5},
        {MakeLens("opencv5", kWideLens), 0.5},
        {MakeLens(kFisheyeModel, kFisheyeTerms), 4.0}}) {
    CameraParameters parameters = testing::RingOfCameras(1)[0].parameters();
    parameters.lens = lens;
    const Camera camera(parameters);
    for (int round = 0; round < 200; ++round) {
      // Every tenth point is within about 1e-9 m of the axis, on which the
      // quotients of the fisheye lens are 0 / 0.
      const double aside = round % 10 == 0 ? 1e-9 : wide_m;
      const Eigen::Vector3d seen(random.Uniform(-aside, aside),
                                 random.Uniform(-aside, aside),
                                 random.Uniform(1.0, 3.0));
      const Eigen::Vector3d point =
          camera.centre() + camera.R().transpose() * seen;
      Matrix23d jacobian;
      ASSERT_TRUE(camera.Project(point, &jacobian).has_value());
      constexpr double kStep = 1e-6;
      for (int axis = 0; axis < 3; ++axis) {
        const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(axis);
        const Eigen::Vector2d slope =
            (*camera.Project(point + step) - *camera.Project(point - step)) /
            (2.0 * kStep);
        // Central differences: rounding 1000 px * 2e-16 / 1e-6 = 2e-7, and a
        // truncation of the order of step^2.
        EXPECT_LT((jacobian.col(axis) - slope).norm(), 1e-5);
      }
    }
  }
}

TEST(CameraTest, APointBeyondTheFoldOfTheLensHasNoImage) {
  CameraParameters p;
  p.lens = MakeLens("opencv5", {-0.3, 0.0});
  const Camera camera(p);
  // d(r - 0.3 r^3)/dr = 0 at r = 1.054.
  EXPECT_TRUE(camera.Project({1.0, 0.0, 1.0}).has_value());
  EXPECT_FALSE(camera.Project({1.1, 0.0, 1.0}).has_value());
  // No ideal point maps beyond r' = 1.054 - 0.3 * 1.054^3 = 0.703.
  EXPECT_FALSE(camera.Undistort({0.8, 0.0}).has_value());
}

TEST(CameraTest, RefusesImpossibleCalibrations) {
  const CameraParameters good = testing::RingOfCameras(1)[0].parameters();
  EXPECT_NO_THROW(Camera{good});
  using Spoil = void (*)(CameraParameters*);
  for (const Spoil spoil :
       {Spoil([](CameraParameters* p) { p->K(0, 0) = 0.0; }),
        Spoil([](CameraParameters* p) { p->K(2, 0) = 0.5; }),
        // A mirror, not a rotation.
        Spoil([](CameraParameters* p) { p->R.row(0) *= -1.0; }),
        Spoil([](CameraParameters* p) { p->R *= 1.01; }),
        Spoil([](CameraParameters* p) { p->t.x() = std::nan(""); }),
        Spoil([](CameraParameters* p) { p->width_px = -1; })}) {
    CameraParameters bad = good;
    spoil(&bad);
    EXPECT_THROW(Camera{bad}, OptionError);
  }
}

TEST(LensTest, RefusesUnknownModelsAndInvalidTerms) {
  EXPECT_THROW(MakeLens("fisheye9", {}), OptionError);
  EXPECT_THROW(MakeLens(kFisheyeModel, {0, 0, 0, 0, 1}), OptionError);
  EXPECT_THROW(MakeLens(kFisheyeModel, {std::nan("")}), OptionError);
  EXPECT_THROW(MakeLens("opencv5", {0.1, 0.2, 0.3}), OptionError);
  EXPECT_THROW(MakeLens("opencv5", {std::nan(""), 0.0}), OptionError);
  EXPECT_THROW(MakeLens("pinhole", {0.1, 0, 0, 0, 0}), OptionError);
  EXPECT_EQ(MakeLens("pinhole", {}), nullptr);
  EXPECT_EQ(MakeLens("pinhole", {0, 0, 0, 0, 0}), nullptr);
  EXPECT_EQ(MakeLens("opencv5", {0, 0, 0, 0, 0}), nullptr);
}

TEST(CameraTest, RaysPassThroughProjectedPoints) {
  const Eigen::Vector3d point(0.3, -0.2, 1.1);
  for (const Camera& camera : testing::RingOfCameras(5)) {
    const auto px = camera.Project(point);
    EXPECT_LT(DistanceToRay(camera, *px, point), 1e-12);
    EXPECT_GT(camera.RayDirection(*px).dot(point - camera.centre()), 0.0);
  }
  CameraParameters p;
  p.K << 500, 0, 320, 0, 500, 240, 0, 0, 1;
  const Camera camera(p);
  // The ray along z; a point 3 to the side and 4 down, at any depth.
  EXPECT_NEAR(DistanceToRay(camera, {320, 240}, {3, 4, 7}), 5.0, 1e-12);
  EXPECT_NEAR(DistanceToRay(camera, {320, 240}, {3, 4, -7}), 5.0, 1e-12);
}

// ---- Fisheye lenses

constexpr double kRightAngle = 1.57079632679489662;

Camera FisheyeCamera(const std::vector<double>& terms = kFisheyeTerms) {
  CameraParameters p;
  p.width_px = 1920;
  p.height_px = 1440;
  p.K << 600, 0, 960, 0, 610, 720, 0, 0, 1;
  p.lens = MakeLens(kFisheyeModel, terms);
  return Camera(p);
}

// The formula of OpenCV's documentation (cv::fisheye), implemented
// independently.
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

// A ray at `angle` off the axis, in direction `about` around it.
Eigen::Vector3d RayAt(double angle, double about) {
  return {std::sin(angle) * std::cos(about), std::sin(angle) * std::sin(about),
          std::cos(angle)};
}

TEST(Fisheye, ProjectionMatchesOpenCvDefinition) {
  const Camera camera = FisheyeCamera();
  for (double angle = 0.01; angle < kRightAngle; angle += 0.05) {
    const Eigen::Vector3d point = 3.0 * RayAt(angle, 7.0 * angle);
    const auto px = camera.Project(point);
    ASSERT_TRUE(px.has_value()) << angle;
    EXPECT_LT((*px - ByTheBook(camera, point)).norm(), 1e-9) << angle;
  }
  EXPECT_EQ(*camera.Project({0, 0, 2}), Eigen::Vector2d(960, 720));
  // A fisheye lens with zero coefficients is not a pinhole.
  EXPECT_NEAR(FisheyeCamera({}).Project({1, 0, 1})->x(),
              960 + 600 * kRightAngle / 2, 1e-9);
}

TEST(Fisheye, UndistortIsTheInverse) {
  for (const auto& terms : {kFisheyeTerms, std::vector<double>{},
                            std::vector<double>{0.3, -0.1, 0.05, 0.01}}) {
    const Camera camera = FisheyeCamera(terms);
    for (double angle = 0.0; angle < kRightAngle - 1e-3; angle += 0.013) {
      const Eigen::Vector3d ray = RayAt(angle, 5.0 * angle);
      const auto ideal = camera.Undistort(*camera.Project(ray));
      ASSERT_TRUE(ideal.has_value()) << angle;
      // Directions of rays are compared, because tan is unbounded. Pixels round
      // to 1e-13 px, 2e-16 rad at a focal length of 600 px; the tolerance is
      // far above that.
      EXPECT_LT((camera.RayDirection(*ideal) - ray).norm(), 1e-12) << angle;
    }
  }
}

TEST(Fisheye, PointsNotInFrontHaveNoImage) {
  const Camera camera = FisheyeCamera({});
  EXPECT_FALSE(camera.Project({1, 0, 0}).has_value()) << "at the side";
  EXPECT_FALSE(camera.Project({1, 0, -0.1}).has_value()) << "behind";
  EXPECT_TRUE(camera.Project({1, 0, 1e-6}).has_value());
  // 90 degrees lie at 600 px * pi / 2 = 942 px from the middle.
  EXPECT_TRUE(camera.Undistort({960 + 942.0, 720}).has_value());
  EXPECT_FALSE(camera.Undistort({960 + 943.0, 720}).has_value());
}

TEST(Fisheye, PointsBeyondTheFoldHaveNoImage) {
  // d(a - 0.3 a^3)/da = 0 at a = 1.054, whose image is 0.703.
  const Camera camera = FisheyeCamera({-0.3});
  EXPECT_TRUE(camera.Project(RayAt(1.05, 0.0)).has_value());
  EXPECT_FALSE(camera.Project(RayAt(1.06, 0.0)).has_value());
  EXPECT_TRUE(camera.Undistort({960 + 600 * 0.702, 720}).has_value());
  EXPECT_FALSE(camera.Undistort({960 + 600 * 0.704, 720}).has_value());
}

// The SIMD kernels equal the computation of a single point, bit for bit.
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

TEST(Fisheye, FirstRadialFactorIsTheDerivativeByK1) {
  const Eigen::Vector2d ideal(0.8, -1.1);
  for (const auto& lens : {MakeLens(kFisheyeModel, kFisheyeTerms),
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
  // Rotation of the image does not change a rotationally symmetric lens.
  const auto lens = MakeLens(kFisheyeModel, kFisheyeTerms);
  EXPECT_EQ(Turned(lens, ImageTurn::kClockwise)->parameters(), kFisheyeTerms);
}

}  // namespace
}  // namespace kinegraph
