// Tests the hypotheses about lost images and about cameras moved during a
// recording, each separately. For complete diagnoses, see doctor_test.cc.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <vector>

#include "solvers/scene/hypothesis.h"
#include "tests/support/walkers_room.h"

namespace kinegraph {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;
using testing::WalkersRoom;

// ---- Images lost or duplicated ----

// From frame 60 on, each frame of the third view shows the image of `missing`
// frames later.
WalkersRoom WithJump(int missing) {
  WalkersRoom room(150);
  room.AddNoise(1.0);
  room.input.detections =
      FramesMoved(room.input.detections, [&](size_t view, int64_t k) {
        return view == 2 && k >= 60 ? k + missing : k;
      });
  return room;
}

TEST(LostPictures, AreCountedAndShiftedBack) {
  const WalkersRoom sound = WithJump(0);
  for (const int missing : {4, -3}) {
    WalkersRoom room = WithJump(missing);
    const auto answer = AskForJump(room.Matched());
    ASSERT_TRUE(answer.has_value()) << missing;
    ASSERT_EQ(answer->findings.size(), 1u);
    EXPECT_EQ(answer->findings[0].kind, "frames");
    EXPECT_EQ(answer->findings[0].camera, "cam2");
    EXPECT_THAT(answer->findings[0].evidence,
                StartsWith(missing > 0 ? "4 images are missing"
                                       : "3 images are in excess"));
    EXPECT_LT(answer->findings[0].after_px, answer->findings[0].before_px);
    // The frame of the jump, 60, is known to 20 frames, less than two bins of
    // half a second; all other images are back in their frames, and after a
    // loss no image appears twice.
    ASSERT_TRUE(answer->detections.has_value());
    std::set<double> shown;
    for (size_t k = 0; k < 150; ++k) {
      const auto& seen = answer->detections->frames[k].views[2].detections;
      if (seen.empty()) continue;
      const Keypoint& nose = seen[0].joints[0];
      if (missing > 0) {
        EXPECT_TRUE(shown.insert(nose.px.x()).second) << k;
      }
      if (k > 40 && k < 80) continue;
      const auto& right =
          sound.input.detections.frames[k].views[2].detections[0].joints[0];
      EXPECT_EQ(nose.px, right.px) << missing << " " << k;
    }
  }
}

TEST(LostPictures, NoneIsFoundWithoutFaultsOrMotionOrInExcludedViews) {
  EXPECT_FALSE(AskForJump(WithJump(0).Matched()).has_value());
  WalkersRoom resting(150);
  resting.input.detections = testing::SeenBy(resting.cameras, 150, [](int) {
    return std::vector<Pose3d>{testing::WalkerOnARound(0)};
  });
  resting.AddNoise(1.0);
  EXPECT_FALSE(AskForJump(resting.Matched()).has_value());
  WalkersRoom stranger = WithJump(4);
  // Qualified, because testing::Test::SetUp() hides the name.
  kinegraph::SetUp set_up = stranger.Matched();
  set_up.strangers.insert(2);
  EXPECT_FALSE(AskForJump(set_up).has_value());
}

// ---- A camera that was moved ----

// The third camera is rotated by 3 degrees, 52 px, from frame 60 on.
WalkersRoom WithTurn() {
  WalkersRoom room(120);
  for (size_t k = 60; k < 120; ++k) {
    for (Keypoint& joint : room.View(k, 2).detections[0].joints) {
      joint.px.x() += 52.0;
    }
  }
  return room;
}

TEST(ACameraThatWasMoved, IsReportedWithTheFrameAndTheBetterSideIsKept) {
  const auto answer = AskForBreak(WithTurn().Looked());
  ASSERT_TRUE(answer.has_value());
  for (const Finding& finding : answer->findings) {
    EXPECT_EQ(finding.camera, "cam2");
    EXPECT_THAT(finding.fix, HasSubstr("--frames=60:120"));
    EXPECT_THAT(finding.evidence, StartsWith("from about frame 60 on: "));
    EXPECT_THAT(finding.evidence, HasSubstr("with --frames=0:60 and"));
  }
  ASSERT_EQ(answer->detections->frames.size(), 60u);
  EXPECT_EQ(answer->detections->frames.back().frame, 59);
}

TEST(ACameraThatWasMoved,
     IsReportedForTheFramesBeforeTheMoveIfCalibratedAfterIt) {
  WalkersRoom room = WithTurn();
  for (size_t k = 0; k < 120; ++k) {
    for (Keypoint& joint : room.View(k, 2).detections[0].joints) {
      joint.px.x() += k < 60 ? 52.0 : -52.0;
    }
  }
  const auto answer = AskForBreak(room.Looked());
  ASSERT_TRUE(answer.has_value());
  EXPECT_THAT(answer->findings[0].evidence,
              StartsWith("before about frame 60: "));
  ASSERT_EQ(answer->detections->frames.size(), 60u);
  EXPECT_EQ(answer->detections->frames.front().frame, 60);
}

TEST(ACameraThatWasMoved, IsNotReportedWithoutFaultsOrForLostImages) {
  EXPECT_FALSE(AskForBreak(WalkersRoom(120).Looked()).has_value());
  // A loss of images of 0.64 s changes the agreement as much as a rotation.
  EXPECT_FALSE(AskForBreak(WithJump(16).Looked()).has_value());
}

TEST(ACameraThatWasMoved, IsNotSearchedWithoutMatchesOrIfDisabledOrInTwoViews) {
  WalkersRoom unmatched = WithTurn();
  unmatched.input.match = nullptr;
  EXPECT_FALSE(AskForBreak(unmatched.Looked()).has_value());
  WalkersRoom part = WithTurn();
  part.options.looks_for_break = false;
  EXPECT_FALSE(AskForBreak(part.Looked()).has_value());
  WalkersRoom two = WithTurn();
  two.cameras = {two.cameras[1], two.cameras[2]};
  two.input.detections.header.view_names = {"cam1", "cam2"};
  for (DetectionFrame& frame : two.input.detections.frames) {
    frame.views = {frame.views[1], frame.views[2]};
  }
  EXPECT_FALSE(AskForBreak(two.Looked()).has_value());
}

}  // namespace
}  // namespace kinegraph
