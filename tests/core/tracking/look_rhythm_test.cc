#include "core/tracking/look_rhythm.h"

#include <gtest/gtest.h>

#include <vector>

namespace kinegraph {
namespace {

constexpr double kCameraRate = 25.0;

class LookRhythmTest : public ::testing::Test {
 protected:
  // The next frame, with or without somebody in one of two views.
  bool See(bool somebody) {
    DetectionFrame frame;
    frame.frame = next_;
    frame.time = FrameClock(kCameraRate).TimeOf(next_++);
    frame.views.resize(2);
    if (somebody) frame.views[1].detections.emplace_back();
    return rhythm_.IsLook(frame);
  }

  LookRhythm rhythm_{FrameClock(kCameraRate)};
  int next_ = 0;
};

TEST_F(LookRhythmTest, OfEveryFrameAnEmptyOneIsAMiss) {
  for (int k = 0; k < 20; ++k) EXPECT_TRUE(See(true));
  EXPECT_TRUE(See(false));
  EXPECT_EQ(rhythm_.usual_frames(), 1.0);
}

TEST_F(LookRhythmTest, EveryThirdFrameTellsTheTwoBetween) {
  for (int k = 0; k < 20; ++k) {
    EXPECT_TRUE(See(true));
    EXPECT_FALSE(See(false));
    EXPECT_FALSE(See(false));
  }
  EXPECT_EQ(rhythm_.usual_frames(), 3.0);
  EXPECT_EQ(rhythm_.newest_frames(), 3.0);
  EXPECT_TRUE(See(false)) << "everybody has gone";
}

TEST_F(LookRhythmTest, AHoleInTheRecordingIsNotUsual) {
  for (int k = 0; k < 20; ++k) See(true);
  next_ += 1000;
  EXPECT_TRUE(See(true));
  EXPECT_EQ(rhythm_.usual_frames(), 1.0);
  EXPECT_EQ(rhythm_.newest_frames(), 1.0) << "one frame is no evidence of 1000";
}

TEST_F(LookRhythmTest, WithoutARhythmNothingIsMissed) {
  EXPECT_FALSE(See(false));
  EXPECT_TRUE(See(true));
  EXPECT_FALSE(See(false));
}

}  // namespace
}  // namespace kinegraph
