#include "solvers/cameras/world_motion.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "solvers/cameras/camera_change.h"
#include "tests/support/rig.h"

namespace kinegraph {
namespace {

using Eigen::Vector3d;

// The rig in a rotated, scaled and translated world.
CameraRig Moved(const CameraRig& cameras, const Eigen::AngleAxisd& turn,
                double scale, const Vector3d& by_m) {
  return Edited(cameras, [&](CameraParameters* parameters) {
    const Vector3d centre = -(parameters->R.transpose() * parameters->t);
    parameters->R = parameters->R * turn.inverse().toRotationMatrix();
    parameters->t = -(parameters->R * (scale * (turn * centre) + by_m));
  });
}

TEST(WorldMotionTest, RecoversTheSimilarityOfTheRig) {
  const CameraRig cameras = testing::RingOfCameras(4);
  const Vector3d axis = Vector3d(1.0, 2.0, -1.0).normalized();
  const auto motion =
      WorldMotionOf(cameras, Moved(cameras, Eigen::AngleAxisd(0.01, axis),
                                   1.002, Vector3d(0.03, 0.0, -0.04)));
  ASSERT_TRUE(motion.has_value());
  EXPECT_NEAR(motion->turned_deg, 0.01 * 57.29577951308232, 1e-9);
  EXPECT_NEAR(motion->scale, 1.002, 1e-9);
  const auto shift =
      WorldMotionOf(cameras, Moved(cameras, Eigen::AngleAxisd::Identity(), 1.0,
                                   Vector3d(0.03, 0.0, -0.04)));
  ASSERT_TRUE(shift.has_value());
  EXPECT_NEAR(shift->moved_m, 0.05, 1e-9);
  EXPECT_NEAR(shift->turned_deg, 0.0, 1e-7);
}

// A common shift of all images rotates or lifts the world although no camera
// moves: vertical shifts of a ring's images by 10 px lift the world.
TEST(WorldMotionTest, IncludesTheEffectOfImageShifts) {
  const CameraRig cameras = testing::RingOfCameras(6);
  const auto still = WorldMotionOf(cameras, cameras);
  ASSERT_TRUE(still.has_value());
  EXPECT_LT(still->moved_m, 1e-9);
  std::vector<CameraChange> changes = NoChanges(cameras.size());
  for (CameraChange& change : changes) change[kShiftAt + 1] = 10.0;
  const auto moved = WorldMotionOf(cameras, RefinedCameras(cameras, changes));
  ASSERT_TRUE(moved.has_value());
  EXPECT_LT(moved->turned_deg, 0.05);
  // 10 px at the focal length and distance of the ring. The tolerance is a
  // tenth, because points of the cube in which WorldMotionOf measures the
  // displacement are nearer to some cameras than to others.
  const double expected_m =
      10.0 * cameras[0].centre().norm() / cameras[0].focal_px();
  EXPECT_NEAR(moved->moved_m, expected_m, 0.1 * expected_m);
}

TEST(WorldMotionTest, IsUndeterminedForParallelAxes) {
  CameraRig cameras = testing::RingOfCameras(1);
  EXPECT_FALSE(WorldMotionOf(cameras, cameras).has_value());
  cameras.push_back(Edited(cameras[0], [](CameraParameters* parameters) {
    parameters->name = "beside";
    parameters->t.x() += 0.2;
  }));
  EXPECT_FALSE(WorldMotionOf(cameras, cameras).has_value());
}

}  // namespace
}  // namespace kinegraph
