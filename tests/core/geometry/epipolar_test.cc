#include "core/geometry/epipolar.h"

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "tests/support/rig.h"

namespace kinegraph {
namespace {

// Two cameras side by side, 1 m apart, looking along z: epipolar lines are
// image rows.
CameraRig StereoPair() {
  CameraParameters left;
  left.name = "left";
  left.K << 500, 0, 320, 0, 500, 240, 0, 0, 1;
  CameraParameters right = left;
  right.name = "right";
  right.t.x() = -1.0;
  return {Camera(left), Camera(right)};
}

TEST(EpipolarTest, LinesOfAStereoPairAreRows) {
  const EpipolarGeometry geometry(StereoPair());
  EXPECT_NEAR(geometry.Distance(0, {100, 200}, 1, {400, 200}), 0.0, 1e-10);
  // Seven rows apart: seven pixels from either line.
  EXPECT_NEAR(geometry.Distance(0, {100, 200}, 1, {400, 207}), 7.0, 1e-10);
  EXPECT_NEAR(geometry.Distance(1, {400, 207}, 0, {100, 200}), 7.0, 1e-10);
}

TEST(EpipolarTest, EachWeightAppliesToThePointOfItsView) {
  // A camera displaced forward: the distances in the two views differ.
  CameraRig cameras = StereoPair();
  CameraParameters moved = cameras[1].parameters();
  moved.t = {-0.5, 0.2, -1.5};
  cameras[1] = Camera(moved);
  const EpipolarGeometry geometry(cameras);
  const Eigen::Vector2d a(150, 300);
  const Eigen::Vector2d b(420, 180);
  const Eigen::Matrix3d F = FundamentalMatrix(cameras[0], cameras[1]);
  const Eigen::Vector3d line_in_b = F * Eigen::Vector3d(a.x(), a.y(), 1);
  const Eigen::Vector3d line_in_a =
      F.transpose() * Eigen::Vector3d(b.x(), b.y(), 1);
  const double d_b = std::abs(line_in_b.dot(Eigen::Vector3d(b.x(), b.y(), 1))) /
                     line_in_b.head<2>().norm();
  const double d_a = std::abs(line_in_a.dot(Eigen::Vector3d(a.x(), a.y(), 1))) /
                     line_in_a.head<2>().norm();
  EXPECT_GT(std::abs(d_a - d_b), 0.1);
  EXPECT_NEAR(geometry.WeightedDistance(0, a, 0.25, 1, b, 0.75),
              (0.25 * d_a + 0.75 * d_b) / 2.0, 1e-9);
}

TEST(EpipolarTest, ZeroForProjectionsOfOnePoint) {
  const CameraRig cameras = testing::RingOfCameras(6);
  const EpipolarGeometry geometry(cameras);
  Random random(5);
  for (int round = 0; round < 100; ++round) {
    const Eigen::Vector3d point(random.Uniform(-2, 2), random.Uniform(-2, 2),
                                random.Uniform(0, 2));
    for (int a = 0; a < 6; ++a) {
      for (int b = 0; b < 6; ++b) {
        // Rounding: pixels of 1e3 at 1e-16, amplified by lines near epipoles.
        EXPECT_LT(geometry.Distance(a, *cameras[a].Project(point), b,
                                    *cameras[b].Project(point)),
                  1e-8);
      }
    }
  }
}

TEST(EpipolarTest, CamerasAtOnePositionHaveNoDistance) {
  CameraRig cameras = StereoPair();
  cameras[1] = cameras[0];
  const EpipolarGeometry geometry(cameras);
  EXPECT_EQ(geometry.Distance(0, {100, 200}, 1, {400, 300}), 0.0);
}

}  // namespace
}  // namespace kinegraph
