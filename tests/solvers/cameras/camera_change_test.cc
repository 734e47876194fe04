#include "solvers/cameras/camera_change.h"

#include <gtest/gtest.h>

#include <utility>

#include "core/base/random.h"
#include "tests/support/rig.h"

namespace kinegraph {
namespace {

// Lenses with large distortion, so that their derivatives matter.
CameraRig BentCameras() {
  CameraRig cameras =
      testing::RingOfCameras(3, 5.0, {-0.2, 0.05, 0.001, -0.002, 0.01});
  for (const Camera& camera : testing::RingOfCameras(3)) {
    cameras.push_back(Edited(camera, [](CameraParameters* bent) {
      bent->lens = MakeLens(kFisheyeModel, {-0.02, 0.015, -0.01, 0.002});
    }));
  }
  return cameras;
}

CameraChange SomeChange() {
  CameraChange change;
  change << 0.02, -0.03, 0.01, 0.05, -0.02, 0.03, 12.0, -7.0, 0.02, 0.04, 1e-4,
      0.05, -0.03;
  return change;
}

TEST(CameraChange, ProjectsLikeTheChangedCamera) {
  const Eigen::Vector3d point(0.3, -0.2, 1.1);
  for (const Camera& camera : BentCameras()) {
    for (const CameraChange& change :
         {CameraChange::Zero().eval(), SomeChange()}) {
      const auto px = ProjectChanged(camera, change, point);
      ASSERT_TRUE(px.has_value());
      // One more subtraction causes rounding differences of about 1e-13 px.
      const Camera changed =
          change.isZero() ? camera : ChangedCamera(camera, change);
      EXPECT_LT((*px - *changed.Project(point)).norm(), 1e-9);
    }
  }
}

TEST(CameraChange, JacobiansMatchNumericDerivatives) {
  const CameraRig cameras = BentCameras();
  const Eigen::Vector3d point(0.3, -0.2, 1.1);
  for (const auto& [camera, change] :
       {std::pair(cameras[1], SomeChange()),
        std::pair(cameras[1], CameraChange(CameraChange::Zero())),
        std::pair(cameras[4], SomeChange()),
        std::pair(cameras[4], CameraChange(CameraChange::Zero()))}) {
    Matrix23d by_point;
    Eigen::Matrix<double, 2, kChangeSize> by_change;
    ASSERT_TRUE(ProjectChanged(camera, change, point, &by_point, &by_change));
    // Central differences: the error is of the order of step^2 times the third
    // derivative (about the focal length of 1000) plus 1e-16 * 1000 / step,
    // i.e. 1e-7; the tolerance is far above that.
    constexpr double kStep = 1e-5;
    constexpr double kTolerance = 2e-4;
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(i);
      const Eigen::Vector2d numeric =
          (*ProjectChanged(camera, change, point + step) -
           *ProjectChanged(camera, change, point - step)) /
          (2.0 * kStep);
      EXPECT_LT((numeric - by_point.col(i)).norm(), kTolerance) << i;
    }
    for (int i = 0; i < kChangeSize; ++i) {
      const CameraChange step = kStep * CameraChange::Unit(i);
      const Eigen::Vector2d numeric =
          (*ProjectChanged(camera, change + step, point) -
           *ProjectChanged(camera, change - step, point)) /
          (2.0 * kStep);
      EXPECT_LT((numeric - by_change.col(i)).norm(), kTolerance) << i;
    }
  }
}

TEST(CameraChange, PointsBehindTheCameraHaveNoImage) {
  const CameraRig cameras = testing::RingOfCameras(2);
  const Camera& camera = cameras[0];
  const Eigen::Vector3d behind = 2.0 * camera.centre();
  EXPECT_FALSE(ProjectChanged(camera, SomeChange(), behind));
}

TEST(FreeParameters, PlacesAreAscending) {
  FreeParameters free;
  EXPECT_TRUE(free.Places().empty());
  free.offset = true;
  free.rotation = true;
  EXPECT_EQ(free.Places(), (std::vector<int>{0, 1, 2, 9}));
  EXPECT_TRUE(free.any_camera());
}

}  // namespace
}  // namespace kinegraph
