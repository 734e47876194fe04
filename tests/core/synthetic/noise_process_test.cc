#include "core/synthetic/noise_process.h"

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>
#include <vector>

namespace kinegraph {
namespace {

struct Runs {
  double share = 0.0;
  double mean_length = 0.0;
  std::vector<int> lengths;
};

Runs RunsOf(const std::vector<bool>& on) {
  Runs runs;
  int current = 0;
  int total = 0;
  for (const bool now : on) {
    total += now ? 1 : 0;
    if (now) {
      ++current;
    } else if (current > 0) {
      runs.lengths.push_back(current);
      current = 0;
    }
  }
  runs.share = static_cast<double>(total) / static_cast<double>(on.size());
  for (const int length : runs.lengths) runs.mean_length += length;
  if (!runs.lengths.empty()) {
    runs.mean_length /= static_cast<double>(runs.lengths.size());
  }
  return runs;
}

constexpr int kFrames = 400000;

class MarkovBurstsTest
    : public ::testing::TestWithParam<std::tuple<double, double>> {};

TEST_P(MarkovBurstsTest, RateAndMeanLength) {
  const auto [rate, frames] = GetParam();
  Random random(7);
  MarkovBursts bursts;
  std::vector<bool> on;
  for (int i = 0; i < kFrames; ++i) {
    on.push_back(bursts.Step(rate, frames, &random));
  }
  const Runs runs = RunsOf(on);
  // Shorter than independent frames is not possible.
  const double length = std::max(frames, 1.0 / (1.0 - rate));
  // The chain's lag-one correlation is 1 - q with q = 1 / (length (1 - rate)),
  // so its variance inflation is (2 - q) / q. Five standard deviations.
  const double q = 1.0 / (length * (1.0 - rate));
  const double sigma = std::sqrt(rate * (1.0 - rate) / kFrames * (2.0 - q) / q);
  EXPECT_NEAR(runs.share, rate, 5.0 * sigma);
  // Geometric lengths: variance below length^2.
  const double runs_sigma =
      length / std::sqrt(static_cast<double>(runs.lengths.size()));
  EXPECT_NEAR(runs.mean_length, length, 5.0 * runs_sigma);
}

INSTANTIATE_TEST_SUITE_P(RatesAndLengths, MarkovBurstsTest,
                         ::testing::Values(std::make_tuple(0.05, 0.0),
                                           std::make_tuple(0.05, 6.0),
                                           std::make_tuple(0.3, 4.0),
                                           std::make_tuple(0.9, 30.0),
                                           std::make_tuple(0.5, 1.0)));

TEST(MarkovBursts, ChangingRateIsFollowedAndEndsAreExact) {
  Random random(3);
  MarkovBursts never;
  MarkovBursts always;
  for (int i = 0; i < 1000; ++i) {
    EXPECT_FALSE(never.Step(0.0, 10.0, &random));
    EXPECT_TRUE(always.Step(1.0, 10.0, &random));
  }
}

class FixedBurstsTest
    : public ::testing::TestWithParam<std::tuple<double, int>> {};

TEST_P(FixedBurstsTest, RateAndExactLength) {
  const auto [rate, frames] = GetParam();
  Random random(11);
  FixedBursts bursts;
  std::vector<bool> on;
  int began = 0;
  int left = 0;
  for (int i = 0; i < kFrames; ++i) {
    bool begins = false;
    on.push_back(bursts.Step(rate, frames, &random, &begins));
    if (begins && i > 0) {
      EXPECT_EQ(left, 0) << "began within a burst";
      ++began;
      left = frames;
    }
    if (left > 0) {
      EXPECT_TRUE(on.back());
      --left;
    }
  }
  // Each burst is n frames; their number varies less than Poisson's.
  const double expected = kFrames * rate / frames;
  EXPECT_NEAR(began, expected, 5.0 * std::sqrt(expected) + 1.0);
  EXPECT_NEAR(RunsOf(on).share, rate,
              (5.0 * std::sqrt(expected) + 1.0) * frames / kFrames);
}

INSTANTIATE_TEST_SUITE_P(RatesAndLengths, FixedBurstsTest,
                         ::testing::Values(std::make_tuple(0.1, 1),
                                           std::make_tuple(0.1, 5),
                                           std::make_tuple(0.4, 12)));

TEST(FixedBursts, StartsInItsStationaryState) {
  // Over many fresh processes every early frame is on with the rate.
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

TEST(SlowGaussian, UnitVarianceAndCorrelation) {
  constexpr double kRho = 0.8;
  Random random(5);
  SlowGaussian process;
  std::vector<double> x;
  for (int i = 0; i < kFrames; ++i)
    x.push_back(process.Step(kRho, &random).x());
  double variance = 0.0;
  double covariance = 0.0;
  for (int i = 0; i + 1 < kFrames; ++i) {
    variance += x[i] * x[i];
    covariance += x[i] * x[i + 1];
  }
  variance /= kFrames - 1;
  covariance /= kFrames - 1;
  // Squares of an AR(1) are correlated by rho^2: the sample variance of
  // n values varies by 2 (1 + rho^2) / (1 - rho^2) / n.
  const double sigma =
      std::sqrt(2.0 * (1.0 + kRho * kRho) / (1.0 - kRho * kRho) / kFrames);
  EXPECT_NEAR(variance, 1.0, 5.0 * sigma);
  EXPECT_NEAR(covariance / variance, kRho, 5.0 * sigma);
}

TEST(SlowStudentScale, GivesStudentTailsOfUnitVariance) {
  constexpr double kDof = 5.0;
  Random random(9);
  SlowStudentScale scale;
  // P(|t| > 2.5706) = 0.05 for 5 degrees of freedom (tables); at unit variance
  // the limit is 2.5706 sqrt(3/5).
  const double limit = 2.5706 * std::sqrt(3.0 / 5.0);
  int beyond = 0;
  double mean_square = 0.0;
  for (int i = 0; i < kFrames; ++i) {
    const double s = scale.Step(0.0, kDof, &random);
    mean_square += s * s;
    beyond += std::abs(s * random.Normal()) > limit ? 1 : 0;
  }
  EXPECT_NEAR(beyond, 0.05 * kFrames, 5.0 * std::sqrt(0.05 * 0.95 * kFrames));
  // E s^2 = 1; E s^4 = (dof - 2) / (dof - 4) = 3.
  EXPECT_NEAR(mean_square / kFrames, 1.0, 5.0 * std::sqrt(2.0 / kFrames) * 2.0);
}

TEST(SlowStudentScale, SlowOneKeepsTheDistribution) {
  constexpr double kDof = 8.0;
  constexpr double kRho = 0.9;
  Random random(13);
  SlowStudentScale scale;
  double inverse = 0.0;  // of s^2: gamma * 2 / (dof - 2), mean dof / (dof - 2)
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
  // Correlation rho; its error is below that of 1/sqrt(n) times the inflation
  // and the kurtosis of the gamma (3 + 6/4 against 3).
  EXPECT_NEAR(product / kFrames / 4.0, kRho,
              5.0 * 2.0 / std::sqrt(kFrames) * inflation);
}

}  // namespace
}  // namespace kinegraph
