#include "core/evaluation/motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "core/base/constants.h"
#include "core/base/error.h"
#include "core/base/random.h"
#include "tests/core/evaluation/people.h"

namespace kinegraph::testing {
namespace {

// One person whose x at time k / rate is `motion` [m].
TrackSequence Moving(int frames, double rate_hz,
                     const std::function<double(double)>& motion) {
  std::vector<TrackFrame> all;
  for (int k = 0; k < frames; ++k) {
    all.push_back(
        Frame(k, {Person(1, Moved(StandingTum14(), motion(k / rate_hz)))}));
  }
  return Tracks(all);
}

TEST(MotionTest, AccelerationIsTheSecondDifference) {
  const TrackSequence even = Moving(5, 4.0, [](double t) { return t; });
  const MotionResult result = EvaluateMotion(even, 25.0);
  EXPECT_EQ(result.acceleration_m_s2, 0.0);
  EXPECT_EQ(result.acceleration_count, 3 * 12);
  EXPECT_EQ(result.bone_length_spread_m, 0.0);
  EXPECT_EQ(result.bone_count, 12);
  MotionOptions first;
  first.frames = {{0, 3}};
  EXPECT_EQ(EvaluateMotion(even, 25.0, first).acceleration_count, 12);
  // a t^2 / 2 with a = 2 m/s^2.
  const TrackSequence fast = Moving(5, 4.0, [](double t) { return t * t; });
  EXPECT_DOUBLE_EQ(EvaluateMotion(fast, 4.0).acceleration_m_s2, 2.0);
}

TEST(MotionTest, NeedsThreeConsecutiveObservedFramesOfOnePerson) {
  // A gap in frame 2, only inferred joints in frame 4, then another person.
  TrackSequence tracks = Standing("0@0 | 0@0 | | 0@0 | 0@9 | 1@0 | 1@0");
  for (Joint3d& joint : tracks.frames[4].people[0].joints) {
    joint.status = JointStatus::kInferred;
  }
  const MotionResult result = EvaluateMotion(tracks, 25.0);
  EXPECT_EQ(result.acceleration_count, 0);
  EXPECT_TRUE(std::isnan(result.acceleration_m_s2));
  EXPECT_TRUE(std::isnan(result.acceleration_interval.low));
}

TEST(MotionTest, BoneSpreadIsTheMeanOfStandardDeviations) {
  const Skeleton arm("arm", {"l_shoulder", "l_elbow", "l_wrist"}, {});
  // The upper arm: 1 and 2 m, deviation 0.5; the forearm: always 1 m. The third
  // frame lacks the shoulder; the second person has one frame only.
  const auto pose = [](double shoulder, double elbow) {
    return Pose3d{Observed(shoulder, 0, 0), Observed(elbow, 0, 0),
                  Observed(elbow + 1, 0, 0)};
  };
  Pose3d lacking = pose(0, 2);
  lacking[0] = Joint3d{};
  const MotionResult result = EvaluateMotion(
      Tracks(
          {Frame(0, {Person(0, pose(0, 1))}), Frame(1, {Person(0, pose(0, 2))}),
           Frame(2, {Person(0, lacking), Person(1, pose(0, 7))})},
          arm),
      25.0);
  EXPECT_EQ(result.bone_count, 2);
  EXPECT_DOUBLE_EQ(result.bone_length_spread_m, 0.25);
}

TEST(MotionTest, RequiresAFrameRate) {
  EXPECT_THROW(EvaluateMotion(Tracks({}), 0.0), OptionError);
  EXPECT_THROW(EstimateLag(Tracks({}), Tracks({}), 0.0), OptionError);
}

TEST(CoverageTest, CountsTruePeopleWithAPoseNearby) {
  const TrackSequence truth = Standing("0@0 1@4 | 0@0");
  // Identity 7 is exactly at the gate of 0.5 m, 8 beyond it.
  const TrackSequence tracks = Standing("7@0.5 8@4.75");
  const Share covered = EvaluateCoverage(truth, tracks);
  EXPECT_EQ(covered.count, 1);
  EXPECT_EQ(covered.total, 3);
  EXPECT_EQ(EvaluateCoverage(truth, tracks, {{1, 2}}).total, 1);
}

TEST(Smoothness, DifferencesOfPolynomialsAreExactDerivatives) {
  // Second and third differences of b t^2 + c t^3 are exact: 2 b + 6 c t at the
  // middle, and 6 c.
  const auto mean = [](int order, const std::function<double(double)>& motion) {
    const TrackSequence tracks = Moving(10, 25.0, motion);
    return PooledRatio(
        DifferenceSeries(tracks, PersonFramesOf(tracks), order, 25.0));
  };
  // Rounding of positions in metres, 1e-16 m, times 25^3.
  EXPECT_NEAR(mean(2, [](double t) { return 0.3 * t * t; }), 0.6, 1e-9);
  EXPECT_NEAR(mean(3, [](double t) { return 0.5 * t * t * t; }), 3.0, 1e-9);
}

TEST(Smoothness, SeriesFollowTheGivenFramesNotTheTracks) {
  TrackSequence tracks = Moving(10, 25.0, [](double t) { return t; });
  const std::vector<PersonFrames> people = PersonFramesOf(tracks);
  tracks.frames[4].people.clear();
  const auto series = DifferenceSeries(tracks, people, 2, 25.0);
  ASSERT_EQ(series.size(), 1u);
  ASSERT_EQ(series[0].size(), 10u);
  // Frame 4 is missing, so no difference starts in frames 2 to 4. Frames 8 and
  // 9 do not have two successors.
  for (size_t k = 0; k < 10; ++k) {
    const bool is_whole = k < 2 || (k > 4 && k < 8);
    EXPECT_EQ(series[0][k].weight, is_whole ? 12.0 : 0.0) << k;
  }
  // Differences ignore inferred joints.
  tracks.frames[1].people[0].joints[0].status = JointStatus::kInferred;
  EXPECT_EQ(DifferenceSeries(tracks, people, 2, 25.0)[0][0].weight, 11.0);
}

double Power(const TrackSequence& tracks, double rate_hz) {
  return PooledRatio(PowerSeries(tracks, PersonFramesOf(tracks), rate_hz));
}

TEST(Power, SineAboveCutoffHasHalfTheSquaredAmplitude) {
  const double rate_hz = 50.0;
  const double amplitude_m = 0.02;
  const auto sine = [&](double frequency_hz) {
    return Moving(400, rate_hz, [=](double t) {
      return 0.7 * t + amplitude_m * std::sin(2.0 * kPi * frequency_hz * t);
    });
  };
  const double expected = 0.5 * amplitude_m * amplitude_m;
  // A Hann window leaks less than 1e-3 of the power beyond two bins (1 Hz), and
  // detrending removes a little of the sine.
  EXPECT_NEAR(Power(sine(9.0), rate_hz) / expected, 1.0, 0.01);
  EXPECT_NEAR(Power(sine(3.0), rate_hz) / expected, 0.0, 1e-3);
}

TEST(Power, WhiteNoiseCountsInProportionToBandwidth) {
  const double rate_hz = 60.0;
  Random random(7);
  const TrackSequence noise =
      Moving(6000, rate_hz, [&](double) { return random.Uniform(-0.5, 0.5); });
  // Variance 1/12; 24 of 30 Hz lie above 6 Hz. All joints move alike, so there
  // are about 6000 / 120 * 2 * 48 bins, which give a standard error of 1.5 %;
  // the tolerance is five times that.
  EXPECT_NEAR(Power(noise, rate_hz), 24.0 / 30.0 / 12.0, 0.06 / 12.0);
}

TEST(Power, IsNaNIfTheFrameRateIsTooLow) {
  const TrackSequence tracks = Moving(100, 12.0, [](double t) { return t; });
  EXPECT_TRUE(std::isnan(Power(tracks, 12.0)));
}

constexpr double kRate = 50.0;

// Two people who sway at different frequencies, delayed by `delay_s`.
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

TEST(Lag, FindsTheDelayToAFractionOfAFrame) {
  const TrackSequence reference = Swaying(0.0);
  for (const double delay_s : {0.0, 0.04, 0.051, 0.13, -0.033}) {
    const auto lag = EstimateLag(reference, Swaying(delay_s, 10), kRate);
    ASSERT_TRUE(lag.has_value()) << delay_s;
    // The parabola through a cosine whose samples are 0.1 rad apart is accurate
    // to a few thousandths of a sample (0.02 s).
    EXPECT_NEAR(*lag, delay_s, 2e-4) << delay_s;
  }
}

TEST(Lag, IsUndefinedWithoutMotionOrOverlap) {
  const TrackSequence still = Alone(StandingTum14(), 1, 100);
  EXPECT_FALSE(EstimateLag(still, still, kRate).has_value());
  EXPECT_FALSE(EstimateLag(Swaying(0.0), Tracks({}), kRate).has_value());
}

}  // namespace
}  // namespace kinegraph::testing
