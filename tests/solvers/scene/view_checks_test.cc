#include <gtest/gtest.h>

#include <string>

#include "solvers/scene/hypothesis.h"
#include "tests/support/faulty_scene.h"

namespace kinegraph {
namespace {

using testing::DiagnoseScene;
using testing::FaultyScene;
using testing::FaultySceneOptions;
using testing::MakeFaultyScene;

FaultyScene FourViews(uint64_t seed) {
  return MakeFaultyScene({seed, 4, 2, 5.0});
}

// Expects that the recording is suspect, that the first finding has this kind
// and camera, and that findings of other kinds have a confidence of at most
// 0.5.
void ExpectOnly(const Diagnosis& diagnosis, const std::string& kind,
                const std::string& camera) {
  ASSERT_FALSE(diagnosis.findings.empty()) << kind;
  std::string words;
  for (const Finding& finding : diagnosis.findings) {
    words +=
        finding.kind + " of " + finding.camera + ": " + finding.evidence + "\n";
  }
  EXPECT_EQ(diagnosis.findings[0].kind, kind) << words;
  EXPECT_EQ(diagnosis.findings[0].camera, camera) << words;
  for (const Finding& finding : diagnosis.findings) {
    EXPECT_TRUE(finding.kind == kind || finding.confidence <= 0.5) << words;
  }
  EXPECT_EQ(diagnosis.verdict, DoctorVerdict::kSuspect);
}

TEST(ViewChecks, ViewWithAnotherFrameRateIsReported) {
  for (const size_t view : {0u, 2u}) {
    FaultyScene scene = FourViews(3);
    auto& frames = scene.detections.frames;
    // At 50 Hz every second image equals an image at 25 Hz, and the others are
    // nearly equal to their predecessors.
    std::vector<ViewDetections> own;
    for (const DetectionFrame& frame : frames) own.push_back(frame.views[view]);
    for (size_t k = 0; k < frames.size(); ++k) {
      frames[k].views[view].detections = own[k / 2].detections;
      if (k % 2 == 0) continue;
      for (Detection& one : frames[k].views[view].detections) {
        for (Keypoint& joint : one.joints) joint.px.x() += 0.5;
      }
    }
    const Diagnosis diagnosis = DiagnoseScene(scene);
    ExpectOnly(diagnosis, "view_rate", scene.cameras[view].name());
    EXPECT_EQ(diagnosis.findings[0].fix,
              "--set=input.view_frame_rate." +
                  scene.detections.header.view_names[view] + "=50");
  }
}

// One view contains every second image, and the first frames of all views have
// the same number and time.
TEST(ViewChecks, ViewWithAnotherFrameRateMayBeginAtAnyNumber) {
  FaultyScene scene = FourViews(3);
  auto& frames = scene.detections.frames;
  std::vector<ViewDetections> own;
  for (const DetectionFrame& frame : frames) own.push_back(frame.views[1]);
  for (size_t k = 0; k < frames.size(); ++k) {
    frames[k].frame += 101;
    auto& seen = frames[k].views[1].detections;
    seen.clear();
    if (2 * k < own.size()) seen = own[2 * k].detections;
  }
  const Diagnosis diagnosis = DiagnoseScene(scene);
  ExpectOnly(diagnosis, "view_rate", scene.cameras[1].name());
  // Image n of the view is simultaneous with frame k = 2 n: from
  // (101 + n - offset) / 12.5 = (101 + k) / 25 follows an offset of 50.5, but
  // the key takes whole frames, so the numbers of all views are shifted to
  // begin at 0.
  std::string keys;
  for (const std::string& name : scene.detections.header.view_names) {
    keys += ";input.view_frame_offset." + name + "=101";
  }
  EXPECT_EQ(diagnosis.findings[0].fix,
            "'--set=input.view_frame_rate." +
                scene.detections.header.view_names[1] + "=12.5" + keys + "'");
}

TEST(ViewChecks, ViewsWithoutACommonFrameAreReported) {
  FaultyScene scene = FourViews(4);
  DetectionSequence apart;
  apart.header = scene.detections.header;
  for (const bool late : {false, true}) {
    for (DetectionFrame frame : scene.detections.frames) {
      for (size_t v = 0; v < 4; ++v) {
        if ((v % 2 == 1) != late) frame.views[v].detections.clear();
      }
      if (late) {
        frame.frame += 5000;
        frame.time += FromSeconds(200.0);
      }
      apart.frames.push_back(std::move(frame));
    }
  }
  scene.detections = std::move(apart);
  const Diagnosis diagnosis = DiagnoseScene(scene);
  ExpectOnly(diagnosis, "frame_range", scene.cameras[1].name());
  ASSERT_EQ(diagnosis.findings.size(), 2u);
  EXPECT_EQ(diagnosis.findings[1].camera, scene.cameras[3].name());
}

// In all images y counts from the bottom, and the cameras are calibrated
// accordingly, so all views agree in a mirror image of the world. Left and
// right exchanged in all views would also look like a mirror image, but people
// would then be upright in the images.
TEST(ViewChecks, MirrorImageOfTheRoomIsReported) {
  FaultyScene scene = FourViews(3);
  const Eigen::DiagonalMatrix<double, 3> flip(1.0, -1.0, 1.0);
  const Eigen::DiagonalMatrix<double, 3> mirror(1.0, 1.0, -1.0);
  for (size_t v = 0; v < scene.cameras.size(); ++v) {
    const double bottom = scene.cameras[v].height_px() - 1.0;
    testing::ChangeJoints(&scene, v, [=](Keypoint* joint) {
      joint->px.y() = bottom - joint->px.y();
    });
    scene.cameras[v] = Edited(scene.cameras[v], [&](CameraParameters* camera) {
      camera->R = flip * camera->R * mirror;
      camera->t = flip * camera->t;
      camera->K(1, 2) = bottom - camera->K(1, 2);
    });
  }
  EXPECT_TRUE(StandOnHeads(scene.detections));
  const Diagnosis diagnosis = DiagnoseScene(scene);
  ExpectOnly(diagnosis, "image", "");
  EXPECT_NE(diagnosis.findings[0].fix.find("kinegraph calibrate RECORDING"),
            std::string::npos);
  for (const std::string& flag : FromTheBottom(scene.cameras)) {
    EXPECT_NE(diagnosis.findings[0].fix.find("=" + flag), std::string::npos);
  }
}

TEST(ViewChecks, ExchangedSidesAreReported) {
  FaultyScene scene = FourViews(5);
  ExchangeSides({0, 0, 1, 0}, &scene.detections);
  ExpectOnly(DiagnoseScene(scene), "sides", scene.cameras[2].name());
  // Exchanged in all other views as well.
  ExchangeSides({1, 1, 0, 1}, &scene.detections);
  ExpectOnly(DiagnoseScene(scene), "sides", "");
}

TEST(ViewChecks, ScaledVideoIsReported) {
  for (const double scale : {0.5, 1.5}) {
    FaultyScene scene = FourViews(6);
    testing::ChangeJoints(&scene, 1, [&](Keypoint* joint) {
      joint->px = scale * joint->px.array() + 0.5 * (scale - 1.0);
    });
    const Diagnosis diagnosis = DiagnoseScene(scene);
    ExpectOnly(diagnosis, "image_size", scene.cameras[1].name());
    EXPECT_NEAR(diagnosis.cameras[1].focal_px(),
                scale * scene.cameras[1].focal_px(), 1e-6);
    EXPECT_EQ(diagnosis.cameras[1].width_px(),
              scale * scene.cameras[1].width_px());
  }
}

// With two views people cannot be triangulated reliably, so image sizes are
// tried directly.
TEST(ViewChecks, ScaledVideoOfTwoViewsIsReported) {
  FaultyScene scene = FourViews(6);
  scene.cameras.erase(scene.cameras.begin() + 2, scene.cameras.end());
  scene.detections.header.view_names.resize(2);
  for (DetectionFrame& frame : scene.detections.frames) frame.views.resize(2);
  testing::ChangeJoints(&scene, 1, [](Keypoint* joint) {
    joint->px = 0.5 * joint->px.array() - 0.25;
  });
  ExpectOnly(DiagnoseScene(scene), "image_size", scene.cameras[1].name());
}

// A shift by 60 of 1,280 pixels may be due to cropping or to a rotated camera,
// so it is reported as a shift, not as a clock error. A smaller shift is not
// reported as a clock error either, although a person walking in one direction
// appears late.
TEST(ViewChecks, SlightlyCroppedImageIsReportedAsShift) {
  FaultyScene scene = FourViews(7);
  testing::ChangeJoints(&scene, 0,
                        [&](Keypoint* joint) { joint->px.x() -= 60.0; });
  ExpectOnly(DiagnoseScene(scene), "shift", scene.cameras[0].name());
  scene = MakeFaultyScene({9, 4, 1, 2.0});
  testing::ChangeJoints(&scene, 0,
                        [&](Keypoint* joint) { joint->px.x() -= 30.0; });
  for (const Finding& finding : DiagnoseScene(scene).findings) {
    EXPECT_NE(finding.kind, "clock_offset") << finding.camera;
  }
}

TEST(ViewChecks, CroppedVideoIsReported) {
  FaultyScene scene = FourViews(7);
  const Eigen::Vector2d offset_px(220.0, 130.0);
  testing::ChangeJoints(&scene, 3,
                        [&](Keypoint* joint) { joint->px -= offset_px; });
  const Diagnosis diagnosis = DiagnoseScene(scene);
  ExpectOnly(diagnosis, "crop", scene.cameras[3].name());
  // The tolerance is the standard deviation of the pixel noise, 2 px.
  const Eigen::Matrix3d moved = scene.cameras[3].K() - diagnosis.cameras[3].K();
  EXPECT_NEAR(moved(0, 2), offset_px.x(), 2.0);
  EXPECT_NEAR(moved(1, 2), offset_px.y(), 2.0);
}

// A few images suffice to determine whether views agree, but not to detect an
// error of one degree.
TEST(ViewChecks, RecordingsWithoutCommonPeopleOrWithFewImagesAreNotExamined) {
  FaultyScene alone = FourViews(8);
  for (DetectionFrame& frame : alone.detections.frames) {
    for (size_t v = 1; v < 4; ++v) frame.views[v].detections.clear();
  }
  FaultyScene few = FourViews(9);
  few.detections.frames.resize(3);
  for (const FaultyScene& scene : {alone, few}) {
    const Diagnosis diagnosis = DiagnoseScene(scene);
    EXPECT_EQ(diagnosis.verdict, DoctorVerdict::kNotExamined);
    EXPECT_TRUE(diagnosis.findings.empty());
    EXPECT_FALSE(diagnosis.notes.empty());
  }
}

}  // namespace
}  // namespace kinegraph
