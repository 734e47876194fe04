#include "core/geometry/camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/base/random.h"
#include "tests/support/rig.h"

namespace kinegraph {
namespace {

// A wide lens: at the corner of the image (r^2 about 1.2) it moves points by
// more than a hundred pixels.
const std::vector<double> kWideLens = {-0.25, 0.08, 0.001, -0.0005, -0.01};

Eigen::Vector3d RandomPointInScene(Random* random) {
  return {random->Uniform(-1.5, 1.5), random->Uniform(-1.5, 1.5),
          random->Uniform(0.0, 2.0)};
}

TEST(CameraTest, ProjectsByHand) {
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

TEST(CameraTest, DistortsByHand) {
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
    const Eigen::Vector3d point = RandomPointInScene(&random);
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
  // How far aside of the axis points are, 1 to 3 m before the camera.
  for (const auto& [lens, wide_m] :
       {std::pair{MakeLens("pinhole", {}), 0.5},
        {MakeLens("opencv5", kWideLens), 0.5},
        {MakeLens(kFisheyeModel, {-0.02, 0.015, -0.01, 0.002}), 4.0}}) {
    CameraParameters parameters = testing::RingOfCameras(1)[0].parameters();
    parameters.lens = lens;
    const Camera camera(parameters);
    for (int round = 0; round < 200; ++round) {
      // Every tenth on the axis to rounding, where the quotients of the fisheye
      // lens are 0 / 0.
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

TEST(CameraTest, APointBeyondTheFoldOfTheLensIsNotSeen) {
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

TEST(LensTest, NamesWhatItDoesNotKnow) {
  EXPECT_THROW(MakeLens("fisheye9", {}), OptionError);
  EXPECT_THROW(MakeLens(kFisheyeModel, {0, 0, 0, 0, 1}), OptionError);
  EXPECT_THROW(MakeLens(kFisheyeModel, {std::nan("")}), OptionError);
  EXPECT_THROW(MakeLens("opencv5", {0.1, 0.2, 0.3}), OptionError);
  EXPECT_THROW(MakeLens("opencv5", {std::nan(""), 0.0}), OptionError);
  EXPECT_EQ(MakeLens("pinhole", {}), nullptr);
  EXPECT_EQ(MakeLens("opencv5", {0, 0, 0, 0, 0}), nullptr);
}

TEST(CameraTest, RaysPassThroughTheirPoints) {
  const Eigen::Vector3d point(0.3, -0.2, 1.1);
  for (const Camera& camera : testing::RingOfCameras(5)) {
    const auto px = camera.Project(point);
    EXPECT_LT(DistanceToRay(camera, *px, point), 1e-12);
    EXPECT_GT(camera.RayDirection(*px).dot(point - camera.centre()), 0.0);
  }
  CameraParameters p;
  p.K << 500, 0, 320, 0, 500, 240, 0, 0, 1;
  const Camera camera(p);
  // The ray along z; a point 3 to the side and 4 up, anywhere along it.
  EXPECT_NEAR(DistanceToRay(camera, {320, 240}, {3, 4, 7}), 5.0, 1e-12);
  EXPECT_NEAR(DistanceToRay(camera, {320, 240}, {3, 4, -7}), 5.0, 1e-12);
}

}  // namespace
}  // namespace kinegraph
