#include "core/base/time.h"

#include <gtest/gtest.h>

namespace kinegraph {
namespace {

TEST(FrameClockTest, WholeFramesAreComparedWithHalfAFrameOfSlack) {
  for (const double rate : {23.976, 25.0, 29.97, 60.0, 120.0}) {
    const FrameClock clock(rate);
    const TimeNs jitter = clock.TimeOf(1) / 3;
    for (int64_t frame = -1000; frame < 1000; ++frame) {
      const TimeNs now = clock.TimeOf(frame);
      for (const TimeNs late : {-jitter, TimeNs{0}, jitter}) {
        EXPECT_TRUE(clock.Less(clock.TimeOf(frame + 2) + late - now, 3.0));
        EXPECT_FALSE(clock.Less(clock.TimeOf(frame + 3) + late - now, 3.0));
      }
    }
  }
}

TEST(FrameClockTest, FramesAndTimeAgree) {
  const FrameClock clock(120.0);
  EXPECT_EQ(clock.TimeOf(120), 1'000'000'000);
  EXPECT_EQ(clock.TimeOf(-60), -500'000'000);
  EXPECT_DOUBLE_EQ(clock.Frames(250'000'000), 30.0);
}

}  // namespace
}  // namespace kinegraph
