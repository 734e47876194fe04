#include "core/synthetic/noise_process.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace kinegraph {
namespace {

constexpr int kFrames = 400000;

TEST(MarkovBursts, HaveTheRequestedRateAndMeanLength) {
  for (const auto& [rate, frames] : {std::pair{0.05, 0.0},
                                     {0.05, 6.0},
                                     {0.3, 4.0},
                                     {0.9, 30.0},
                                     {0.5, 1.0}}) {
    SCOPED_TRACE(std::to_string(rate) + ", " + std::to_string(frames));
    Random random(7);
    MarkovBursts bursts;
    double on = 0.0, runs = 0.0;
    bool before = false;
    for (int i = 0; i < kFrames; ++i) {
      const bool now = bursts.Step(rate, frames, &random);
      on += now ? 1.0 : 0.0;
      runs += now && !before ? 1.0 : 0.0;
      before = now;
    }
    // Bursts cannot be shorter than those of independent frames.
    const double length = std::max(frames, 1.0 / (1.0 - rate));
    // The chain's lag-one correlation is 1 - q with q = 1 / (length (1 -
    // rate)), so its variance inflation is (2 - q) / q. The tolerance is five
    // standard deviations.
    const double q = 1.0 / (length * (1.0 - rate));
    EXPECT_NEAR(on / kFrames, rate,
                5.0 * std::sqrt(rate * (1.0 - rate) / kFrames * (2.0 - q) / q));
    // Geometric lengths: variance below length^2.
    EXPECT_NEAR(on / runs, length, 5.0 * length / std::sqrt(runs));
  }
}

TEST(MarkovBursts, RatesOfZeroAndOneAreExact) {
  Random random(3);
  MarkovBursts never;
  MarkovBursts always;
  for (int i = 0; i < 1000; ++i) {
    EXPECT_FALSE(never.Step(0.0, 10.0, &random));
    EXPECT_TRUE(always.Step(1.0, 10.0, &random));
  }
}

TEST(MarkovBursts, AlternatingRatesHoldInTheirFrames) {
  constexpr std::array<double, 2> kRates = {0.1, 0.6};
  constexpr double kBurst = 6.0;  // frames
  constexpr int kRun = 50;        // frames at one rate, then at the other
  Random random(11);
  MarkovBursts bursts;
  std::array<double, 2> on = {0.0, 0.0};
  for (int i = 0; i < kFrames; ++i) {
    const size_t k = i / kRun % 2;
    on[k] += bursts.Step(kRates[k], kBurst, &random) ? 1.0 : 0.0;
  }
  // Tolerance as in the first test, with the slower chain of the two rates: q
  // is less at the lower rate.
  const double q = 1.0 / (kBurst * (1.0 - kRates[0]));
  for (size_t k = 0; k < 2; ++k) {
    const double variance = kRates[k] * (1.0 - kRates[k]) / (kFrames / 2);
    EXPECT_NEAR(on[k] / (kFrames / 2), kRates[k],
                5.0 * std::sqrt(variance * (2.0 - q) / q));
  }
}

TEST(FixedBursts, StartsInTheStationaryState) {
  // Over many new processes, each of the first frames is on with the stationary
  // rate.
  constexpr int kProcesses = 20000;
  constexpr double kRate = 0.2;
  std::vector<int> on(6, 0);
  for (int i = 0; i < kProcesses; ++i) {
    Random random(1000 + i);
    FixedBursts bursts;
    bool began = false;
    for (int& count : on) {
      count += bursts.Step(kRate, 4, &random, &began) ? 1 : 0;
    }
  }
  const double sigma = std::sqrt(kRate * (1.0 - kRate) * kProcesses);
  for (const int count : on) {
    EXPECT_NEAR(count, kRate * kProcesses, 5.0 * sigma);
  }
}

TEST(SlowStudentScale, SlowScaleKeepsTheDistribution) {
  constexpr double kDof = 8.0;
  constexpr double kRho = 0.9;
  Random random(13);
  SlowStudentScale scale;
  double inverse = 0.0;  // sum of (dof - 2) / (2 s^2)
  double product = 0.0;
  double last = 0.0;
  std::vector<double> g;
  for (int i = 0; i < kFrames; ++i) {
    const double s = scale.Step(kRho, kDof, &random);
    g.push_back((kDof - 2.0) / (2.0 * s * s));  // Gamma(4): mean 4, variance 4
    inverse += g.back();
    if (i > 0) product += (g.back() - 4.0) * (last - 4.0);
    last = g.back();
  }
  const double inflation = std::sqrt((1.0 + kRho) / (1.0 - kRho));
  EXPECT_NEAR(inverse / kFrames, 4.0,
              5.0 * 2.0 / std::sqrt(kFrames) * inflation);
  // Correlation rho; its error is below 1/sqrt(n) times the inflation and a
  // factor for the kurtosis of the gamma distribution (3 + 6/4 against 3).
  EXPECT_NEAR(product / kFrames / 4.0, kRho,
              5.0 * 2.0 / std::sqrt(kFrames) * inflation);
}

}  // namespace
}  // namespace kinegraph
