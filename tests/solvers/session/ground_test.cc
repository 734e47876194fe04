#include "solvers/session/ground.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "core/synthetic/scene.h"
#include "solvers/cameras/camera_change.h"

namespace kinegraph {
namespace {

// The floor is found for exact people in a tilted and displaced world.
TEST(Ground, TiltedWorldIsLevelled) {
  SceneOptions options;
  options.seed = 31;
  options.people = 4;
  options.duration_s = 8.0;
  options.motion.visitors = 0.0;
  const Scene scene = MakeScene(options);
  TrackSequence tracks = TruthOf(scene);
  const Eigen::Matrix3d turn =
      (Eigen::AngleAxisd(1.4, Eigen::Vector3d::UnitX()) *
       Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY()))
          .toRotationMatrix();
  const Eigen::Vector3d moved(3.0, -2.0, 5.0);
  for (TrackFrame& frame : tracks.frames) {
    for (PersonPose& person : frame.people) {
      for (Joint3d& joint : person.joints) {
        joint.position_m = turn * joint.position_m + moved;
      }
    }
  }
  const auto ground = GroundOf(tracks.header, tracks.frames);
  ASSERT_TRUE(ground.has_value());
  // The synthetic world has its floor at z = 0. Ankles move a little during
  // stance, which tilts the plane by about a degree (0.02 rad) at most.
  const Eigen::Vector3d up = ground->R * turn * Eigen::Vector3d::UnitZ();
  EXPECT_GT(up.z(), std::cos(0.02));
  // Statures have a standard deviation of 9 cm, so ankles differ in height by 4
  // mm, and a resting ankle rises with the heel.
  EXPECT_NEAR((ground->R * moved + ground->t).z(), 0.0, 0.04);
  EXPECT_NEAR(ground->R.determinant(), 1.0, 1e-9);
  // Cameras moved with the world project to the same pixels.
  const CameraRig turned = Edited(scene.cameras, [&](CameraParameters* camera) {
    camera->R = camera->R * turn.transpose();
    camera->t = camera->t - camera->R * moved;
  });
  const CameraRig upright = OnGround(turned, *ground);
  const Eigen::Vector3d point = tracks.frames[0].people[0].joints[0].position_m;
  for (size_t v = 0; v < turned.size(); ++v) {
    const auto before = turned[v].Project(point);
    const auto after = upright[v].Project(ground->R * point + ground->t);
    ASSERT_EQ(before.has_value(), after.has_value());
    if (before.has_value()) {
      EXPECT_LT((*before - *after).norm(), 1e-6);
    }
  }
}

// At 2.5 Hz consecutive frames are 0.4 s apart. At high frame rates, the speed
// of a foot is measured over at most 0.3 s.
TEST(Ground, LowFrameRatesSuffice) {
  SceneOptions options;
  options.seed = 31;
  options.people = 4;
  options.duration_s = 60.0;
  options.frame_rate_hz = 2.5;
  options.motion.visitors = 0.0;
  const TrackSequence tracks = TruthOf(MakeScene(options));
  const auto ground = GroundOf(tracks.header, tracks.frames);
  ASSERT_TRUE(ground.has_value());
  EXPECT_GT(ground->R(2, 2), std::cos(0.02));
  EXPECT_NEAR(ground->t.z(), 0.0, 0.06);
}

TEST(Ground, NoGroundWithoutPeople) {
  EXPECT_FALSE(GroundOf(TrackHeader(), {}).has_value());
}

}  // namespace
}  // namespace kinegraph
