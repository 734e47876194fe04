// Tests that individual clocks and cameras with errors are identified from the
// residuals of known matches.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "solvers/cameras/camera_change.h"
#include "solvers/scene/hypothesis.h"
#include "tests/support/walkers_room.h"

namespace kinegraph {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::WalkersRoom;

WalkersRoom NoisyRoom() {
  WalkersRoom room(120);
  room.AddNoise(1.0);
  return room;
}

// A room in which one camera has the given change.
WalkersRoom WithChange(size_t view, const CameraChange& change) {
  WalkersRoom room = NoisyRoom();
  room.cameras[view] = ChangedCamera(room.cameras[view], change);
  return room;
}

// Rotation about the optical axis, which a shift of the image cannot explain.
CameraChange Roll(double rad) {
  CameraChange change = CameraChange::Zero();
  change[kRotationAt + 2] = rad;
  return change;
}

TEST(Residuals, NoFindingsWithoutFaults) {
  WalkersRoom room = NoisyRoom();
  const auto answer = AskResiduals(room.Matched());
  ASSERT_TRUE(answer.has_value());
  EXPECT_THAT(answer->findings, IsEmpty());
  for (size_t v = 0; v < 4; ++v) {
    EXPECT_EQ((*answer->cameras)[v].R(), room.cameras[v].R());
    EXPECT_EQ((*answer->cameras)[v].K(), room.cameras[v].K());
  }
}

TEST(Residuals, OnlyTheLateViewIsReported) {
  WalkersRoom room = NoisyRoom();
  // The view's recorded times are 24 ms too early.
  for (size_t k = 0; k < 120; ++k) {
    room.View(k, 1).capture_time -= FromSeconds(0.024);
  }
  const auto answer = AskResiduals(room.Matched());
  ASSERT_TRUE(answer.has_value());
  ASSERT_EQ(answer->findings.size(), 1u);
  const Finding& finding = answer->findings[0];
  EXPECT_EQ(finding.kind, "clock_offset");
  EXPECT_EQ(finding.camera, "cam1");
  EXPECT_EQ(finding.fix, kRefineClocks);
  const auto at = finding.evidence.find('+');
  ASSERT_NE(at, std::string::npos) << finding.evidence;
  // 1 px of noise corresponds to 5 ms for a person walking at 1 m/s; averaged
  // over 120 segments, to less than 0.5 ms. The tolerance is four times that.
  EXPECT_NEAR(std::stod(finding.evidence.substr(at)), 24.0, 2.0);
}

TEST(Residuals, PersonAtRestGivesNoClockFindings) {
  WalkersRoom room(120);
  room.input.detections = testing::SeenBy(room.cameras, 120, [](int) {
    return std::vector<Pose3d>{testing::WalkerOnARound(0)};
  });
  room.AddNoise(1.0);
  for (size_t k = 0; k < 120; ++k) {
    room.View(k, 1).capture_time -= FromSeconds(0.024);
  }
  EXPECT_THAT(AskResiduals(room.Matched())->findings, IsEmpty());
}

TEST(Residuals, OnlyTheRotatedCameraIsCorrected) {
  WalkersRoom room = WithChange(3, Roll(0.1));
  const CameraRig truth = NoisyRoom().cameras;
  const auto answer = AskResiduals(room.Matched());
  ASSERT_EQ(answer->findings.size(), 1u);
  EXPECT_EQ(answer->findings[0].kind, "rotation");
  EXPECT_EQ(answer->findings[0].camera, "cam3");
  EXPECT_EQ(answer->findings[0].fix, kUseCorrected);
  EXPECT_TRUE(answer->findings[0].significant);
  for (size_t v = 0; v < 4; ++v) {
    // Joints lie about 100 px from the image centre, so 1 px of noise is a
    // rotation by 1e-2 rad, averaged over 700 joints by 4e-4 rad. The norm of
    // the difference of matrices is 1.4 times as large.
    EXPECT_LT(((*answer->cameras)[v].R() - truth[v].R()).norm(),
              v == 3 ? 2e-3 : 1e-15);
  }
}

// Changes within three of the calibration's stated standard deviations are
// insignificant.
TEST(Residuals, ChangesWithinStatedUncertaintyAreInsignificant) {
  for (const double sigma : {0.02, 0.05}) {
    WalkersRoom room = WithChange(3, Roll(0.1));
    room.input.stated_sigma = NoChanges(4);
    room.input.stated_sigma[3].setConstant(sigma);
    const auto answer = AskResiduals(room.Matched());
    ASSERT_EQ(answer->findings.size(), 1u);
    EXPECT_EQ(answer->findings[0].significant, 3.0 * sigma < 0.1);
    EXPECT_EQ(answer->findings[0].confidence > 0.5, 3.0 * sigma < 0.1);
    if (!answer->findings[0].significant) {
      EXPECT_THAT(
          answer->findings[0].evidence,
          HasSubstr("within the stated uncertainty of the calibration"));
    }
    EXPECT_EQ((*answer->cameras)[3].R() == room.cameras[3].R(),
              !answer->findings[0].significant);
  }
}

// If people stay in one place, a change no larger than a detector's bias cannot
// be distinguished from it.
TEST(Residuals, ChangeAsLargeAsDetectorBiasIsInsignificant) {
  WalkersRoom room(120);
  room.input.detections = testing::SeenBy(room.cameras, 120, [](int) {
    return std::vector<Pose3d>{testing::WalkerOnARound(0)};
  });
  room.AddNoise(1.0);
  CameraChange shift = CameraChange::Zero();
  shift[kShiftAt] = 12.0;  // 60 mm at 5 m
  room.cameras[1] = ChangedCamera(room.cameras[1], shift);
  const auto answer = AskResiduals(room.Matched());
  ASSERT_EQ(answer->findings.size(), 1u);
  EXPECT_EQ(answer->findings[0].camera, "cam1");
  EXPECT_FALSE(answer->findings[0].significant);
  EXPECT_THAT(answer->findings[0].evidence,
              HasSubstr("people stay in one place"));
}

}  // namespace
}  // namespace kinegraph
