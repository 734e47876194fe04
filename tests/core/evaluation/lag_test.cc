#include "core/evaluation/lag.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.h"
#include "tests/core/evaluation/people.h"

namespace kinegraph {
namespace {

using testing::Frame;
using testing::Moved;
using testing::Person;
using testing::StandingTum14;
using testing::Tracks;

constexpr double kRate = 50.0;

// Two people who sway at different frequencies, `delay_s` late.
TrackSequence Swaying(double delay_s, int64_t first_id = 1) {
  std::vector<TrackFrame> all;
  for (int k = 0; k < 300; ++k) {
    const double t = k / kRate - delay_s;
    const Pose3d one = Moved(StandingTum14(), 0.2 * std::sin(5.0 * t),
                             0.1 * std::cos(3.0 * t));
    const Pose3d two =
        Moved(StandingTum14(), 3.0, 0.15 * std::sin(4.0 * t + 1.0));
    all.push_back(Frame(k, {Person(first_id, one), Person(first_id + 1, two)}));
  }
  return Tracks(all);
}

TEST(Lag, IsThatOfADelayedMotionAlsoBetweenFrames) {
  const TrackSequence reference = Swaying(0.0);
  for (const double delay_s : {0.0, 0.04, 0.051, 0.13, -0.033}) {
    const auto lag = EstimateLag(reference, Swaying(delay_s, 10), kRate);
    ASSERT_TRUE(lag.has_value()) << delay_s;
    // The parabola through a cosine whose samples are 0.1 rad apart is right
    // to a few thousandths of a sample (0.02 s).
    EXPECT_NEAR(*lag, delay_s, 2e-4) << delay_s;
  }
}

TEST(Lag, DoesNotExistWhereNobodyMovesOrNothingOverlaps) {
  std::vector<TrackFrame> still;
  for (int k = 0; k < 100; ++k) {
    still.push_back(Frame(k, {Person(1, StandingTum14())}));
  }
  EXPECT_FALSE(EstimateLag(Tracks(still), Tracks(still), kRate).has_value());
  EXPECT_FALSE(EstimateLag(Swaying(0.0), Tracks({}), kRate).has_value());
}

TEST(Lag, NeedsAFrameRate) {
  EXPECT_THROW(EstimateLag(Swaying(0.0), Swaying(0.0), 0.0), OptionError);
}

}  // namespace
}  // namespace kinegraph
