#include "core/evaluation/smoothness.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "core/base/constants.h"
#include "tests/core/evaluation/people.h"

namespace kinegraph {
namespace {

using testing::Frame;
using testing::Moved;
using testing::Person;
using testing::StandingTum14;
using testing::Tracks;

// One person who moves along x as `motion` says [m] at times k / rate.
TrackSequence Moving(int frames, double rate_hz,
                     const std::function<double(double)>& motion) {
  std::vector<TrackFrame> all;
  for (int k = 0; k < frames; ++k) {
    all.push_back(
        Frame(k, {Person(1, Moved(StandingTum14(), motion(k / rate_hz)))}));
  }
  return Tracks(all);
}

TEST(Smoothness, DifferencesOfAPolynomialAreItsDerivatives) {
  // Second and third differences of a cubic are exact: 2 b + 6 c t_mid, 6 c.
  const double rate_hz = 25.0;
  const auto parabola = [](double t) { return 0.3 * t * t; };
  const auto cubic = [](double t) { return 0.5 * t * t * t; };
  const TrackSequence bent = Moving(10, rate_hz, parabola);
  const TrackSequence jerky = Moving(10, rate_hz, cubic);
  // Positions of metres carry 1e-16 m, times 25^3.
  EXPECT_NEAR(
      PooledRatio(DifferenceSeries(bent, PersonFramesOf(bent), 2, rate_hz)),
      0.6, 1e-9);
  EXPECT_NEAR(
      PooledRatio(DifferenceSeries(jerky, PersonFramesOf(jerky), 3, rate_hz)),
      3.0, 1e-9);
}

TEST(Smoothness, UnitsFollowTheGivenFramesNotTheTracks) {
  TrackSequence tracks = Moving(10, 25.0, [](double t) { return t; });
  const std::vector<PersonFrames> people = PersonFramesOf(tracks);
  tracks.frames[4].people.clear();
  const auto series = DifferenceSeries(tracks, people, 2, 25.0);
  ASSERT_EQ(series.size(), 1u);
  ASSERT_EQ(series[0].size(), 10u);
  // Frames 2, 3, 4 lack a neighbour or themselves, 8 and 9 have no successors.
  for (const size_t k : {2u, 3u, 4u, 8u, 9u}) {
    EXPECT_EQ(series[0][k].weight, 0.0) << k;
  }
  for (const size_t k : {0u, 1u, 5u, 6u, 7u}) {
    EXPECT_EQ(series[0][k].weight, 12.0) << k;
  }
}

TEST(Smoothness, InferredJointsAreNotJudgedByDifferences) {
  TrackSequence tracks = Moving(3, 25.0, [](double t) { return t; });
  tracks.frames[1].people[0].joints[0].status = JointStatus::kInferred;
  const auto series = DifferenceSeries(tracks, PersonFramesOf(tracks), 2, 25.0);
  EXPECT_EQ(series[0][0].weight, 11.0);
}

double Power(const TrackSequence& tracks, double rate_hz) {
  return PooledRatio(PowerSeries(tracks, PersonFramesOf(tracks), rate_hz));
}

TEST(Power, OfASineIsHalfItsSquaredAmplitudeAboveTheCutoffAlone) {
  const double rate_hz = 50.0;
  const double amplitude_m = 0.02;
  const auto sine = [&](double frequency_hz) {
    return Moving(400, rate_hz, [=](double t) {
      return 0.7 * t + amplitude_m * std::sin(2.0 * kPi * frequency_hz * t);
    });
  };
  const double expected = 0.5 * amplitude_m * amplitude_m;
  // A Hann window leaks beyond two bins (1 Hz) with less than 1e-3 in power,
  // and taking out the line takes a little of the sine with it.
  EXPECT_NEAR(Power(sine(9.0), rate_hz) / expected, 1.0, 0.01);
  EXPECT_NEAR(Power(sine(3.0), rate_hz) / expected, 0.0, 1e-3);
}

TEST(Power, OfWhiteNoiseIsItsVarianceTimesTheShareOfFrequencies) {
  const double rate_hz = 60.0;
  uint64_t state = 7;
  const auto uniform = [&state] {  // Knuth's 64-bit linear congruence
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<double>(state >> 11) / 9007199254740992.0 - 0.5;
  };
  const TrackSequence noise =
      Moving(6000, rate_hz, [&](double) { return uniform(); });
  // Variance 1/12; 24 of 30 Hz lie above 6 Hz. All joints move alike, so there
  // are about 6000 / 120 * 2 * 48 bins: 1.5 % of standard error.
  EXPECT_NEAR(Power(noise, rate_hz), 24.0 / 30.0 / 12.0, 0.06 / 12.0);
}

TEST(Power, NeedsARateThatCanShowIt) {
  const TrackSequence tracks = Moving(100, 12.0, [](double t) { return t; });
  EXPECT_TRUE(std::isnan(Power(tracks, 12.0)));
}

}  // namespace
}  // namespace kinegraph
