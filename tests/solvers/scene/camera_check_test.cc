#include "solvers/scene/camera_check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/faulty_scene.h"

namespace kinegraph {
namespace {

using testing::FaultyScene;
using testing::FaultySceneOptions;
using testing::MakeFaultyScene;

// A check with the true tracks, so that its findings are due to cameras, clocks
// and detections only.
// `skeleton`: of the tracks; all its joints are joints of the scene's skeleton.
CameraCheck CheckOf(const FaultyScene& scene, const Skeleton& skeleton) {
  CameraCheck check(scene.cameras, scene.detections.header.skeleton, skeleton);
  const std::vector<int> map = MapByName(scene.scene.skeleton, skeleton);
  std::vector<TrackFrame> tracked = TruthOf(scene.scene).frames;
  for (size_t k = 0; k < tracked.size(); ++k) {
    for (PersonPose& person : tracked[k].people) {
      Pose3d joints;
      for (const int j : map) joints.push_back(person.joints.at(j));
      person.joints = std::move(joints);
    }
    check.See(scene.detections.frames[k], tracked[k]);
  }
  return check;
}

CameraCheck CheckOf(const FaultyScene& scene) {
  return CheckOf(scene, scene.scene.skeleton);
}

std::string Words(const CameraCheck& check) {
  std::string words;
  for (const CameraWarning& one : check.Warnings()) words += one.text + "; ";
  return words;
}

TEST(CameraCheck, DoesNotWarnAboutCorrectCameras) {
  const CameraCheck check = CheckOf(MakeFaultyScene({31}));
  EXPECT_EQ(Words(check), "");
  for (const CameraCheck::View& view : check.Views()) {
    EXPECT_GE(view.in_motion, 60u);
    // 2 px correspond to 20 ms at walking speed; the mean of 60 segments with
    // independent errors has a standard error of 20 / sqrt(60) ms. The limit is
    // four standard errors.
    EXPECT_LT(std::abs(view.late_s), 0.01);
  }
}

TEST(CameraCheck, WarnsAboutAShiftedImage) {
  FaultyScene scene = MakeFaultyScene({32});
  scene.cameras[1] = testing::Shifted(scene.cameras[1], 25.0, 10.0);
  const CameraCheck check = CheckOf(scene);
  EXPECT_NE(Words(check).find("'" + scene.cameras[1].name() + "' sees people"),
            std::string::npos)
      << Words(check);
  // The image centre moves right and down, so people appear to be left and up.
  // The tolerance is the standard deviation of the pixel noise, 2 px.
  EXPECT_NEAR(check.Views()[1].x_px, -25.0, 2.0);
  EXPECT_NEAR(check.Views()[1].y_px, -10.0, 2.0);
}

// Detections and tracks have only the joints of the trunk in common.
TEST(CameraCheck, TracksOfFourJointsSuffice) {
  FaultyScene scene = MakeFaultyScene({32});
  scene.cameras[1] = testing::Shifted(scene.cameras[1], 25.0, 10.0);
  const CameraCheck check = CheckOf(
      scene,
      Skeleton("trunk", {"l_shoulder", "r_shoulder", "l_hip", "r_hip"}, {}));
  EXPECT_NE(Words(check).find("'" + scene.cameras[1].name() + "' sees people"),
            std::string::npos)
      << Words(check);
}

// Cameras side by side triangulate few joints, and these inaccurately.
TEST(CameraCheck, DoesNotWarnAboutCamerasSideBySide) {
  for (const uint64_t seed : {3, 4, 5}) {
    for (const double apart_m : {0.1, 0.3, 0.6}) {
      FaultyScene scene = MakeFaultyScene({seed, 2});
      CameraRig& cameras = scene.scene.cameras;
      cameras[1] = testing::WithExtrinsics(
          cameras[1], cameras[0].R(),
          cameras[0].t() - Eigen::Vector3d(apart_m, 0.0, 0.0));
      NoiseOptions noise;
      noise.joints.sigma_px = 2.0;
      noise.joints.outlier_rate = 0.02;
      scene.cameras = cameras;
      scene.detections = Observe(scene.scene, noise, nullptr);
      EXPECT_EQ(Words(CheckOf(scene)), "") << seed << " " << apart_m;
    }
  }
}

TEST(CameraCheck, WarnsAboutALateClockUnlessCaptureTimesAreCorrect) {
  FaultySceneOptions options = {33};
  options.clock_offset_s = {0.0, 0.0, 0.1, 0.0, 0.0};
  FaultyScene scene = MakeFaultyScene(options);
  const CameraCheck check = CheckOf(scene);
  const std::string name = "'" + scene.cameras[2].name() + "'";
  EXPECT_NE(Words(check).find(name + " sees people about"), std::string::npos)
      << Words(check);
  EXPECT_NE(Words(check).find("later than the other views"), std::string::npos);
  // The other clocks are correct, so points triangulated from the other views
  // are correct at the recorded time. A segment of 0.2 s only approximates the
  // motion of a walking person.
  EXPECT_NEAR(check.Views()[2].late_s, 0.1, 0.015);
  for (DetectionFrame& frame : scene.detections.frames) {
    frame.views[2].capture_time += FromSeconds(0.1);
  }
  const CameraCheck corrected = CheckOf(scene);
  EXPECT_EQ(Words(corrected), "");
  EXPECT_NEAR(corrected.Views()[2].late_s, 0.0, 0.015);
}

TEST(CameraCheck, TwoCamerasAreCheckedWithEpipolarLines) {
  FaultySceneOptions options = {35, 2};
  options.arc_deg = 90.0;
  FaultyScene scene = MakeFaultyScene(options);
  EXPECT_EQ(Words(CheckOf(scene)), "");
  // For cameras at similar heights, epipolar lines are nearly horizontal, and a
  // vertical shift is nearly perpendicular to them.
  scene.cameras[1] = testing::Shifted(scene.cameras[1], 0.0, 25.0);
  const CameraCheck check = CheckOf(scene);
  EXPECT_NE(Words(check), "");
  EXPECT_NEAR(check.Views()[1].y_px, -25.0, 5.0);
}

TEST(CameraCheck, CoversTheWholeRecording) {
  FaultySceneOptions options = {34};
  options.duration_s = 60.0;  // 1500 frames
  FaultyScene scene = MakeFaultyScene(options);
  // The camera is knocked after the first third.
  testing::ChangeJoints(
      &scene, 0, [](Keypoint* joint) { joint->px.x() -= 40.0; }, 500);
  const CameraCheck check = CheckOf(scene);
  EXPECT_NE(Words(check), "");
  EXPECT_LT(check.Views()[0].x_px, -30.0);
}

// Detections that are read again for the report have the times of the file,
// which may stop or restart.
TEST(CameraCheck, AClockThatStopsOrRestartsIsNoError) {
  FaultySceneOptions options = {36};
  options.duration_s = 80.0;  // 2000 frames
  const FaultyScene scene = MakeFaultyScene(options);
  for (const size_t clip : {1, 25}) {
    FaultyScene restarted = scene;
    const Scene& truth = restarted.scene;
    CameraCheck check(restarted.cameras, scene.detections.header.skeleton,
                      truth.skeleton);
    const std::vector<TrackFrame> tracked = TruthOf(truth).frames;
    for (size_t k = 0; k < tracked.size(); ++k) {
      DetectionFrame& frame = restarted.detections.frames[k];
      frame.time = scene.detections.frames[k % clip].time;
      for (ViewDetections& view : frame.views) view.capture_time = frame.time;
      check.See(frame, tracked[k]);
    }
    const std::vector<CameraCheck::View> views = check.Views();
    ASSERT_EQ(views.size(), 5u);
    for (const CameraCheck::View& view : views) EXPECT_GT(view.people, 0);
  }
}

}  // namespace
}  // namespace kinegraph
