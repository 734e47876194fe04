#include "core/evaluation/statistics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <vector>

#include "core/base/error.h"
#include "core/base/random.h"

namespace kinegraph {
namespace {

TEST(ShareTest, FractionOfNoneIsNaN) {
  EXPECT_TRUE(std::isnan(Share{}.fraction()));
  EXPECT_EQ((Share{3, 4}.percent()), 75.0);
}

TEST(ShareTest, AddsUp) {
  Share share{1, 2};
  share.Add(true);
  share.Add(false);
  share += Share{1, 1};
  EXPECT_EQ(share.count, 3);
  EXPECT_EQ(share.total, 5);
}

TEST(StatisticsTest, MeanAndDeviationMatchHandComputedValues) {
  EXPECT_EQ(Mean({1.0, 3.0}), 2.0);
  EXPECT_EQ(StandardDeviation({1.0, 3.0}), 1.0);
  EXPECT_TRUE(std::isnan(Mean({})));
  EXPECT_TRUE(std::isnan(StandardDeviation({})));
}

TEST(QuantileTest, InterpolatesBetweenOrderStatistics) {
  EXPECT_EQ(Quantile({30.0, 10.0, 20.0, 40.0}, 0.0), 10.0);
  EXPECT_EQ(Quantile({30.0, 10.0, 20.0, 40.0}, 0.5), 25.0);
  EXPECT_EQ(Quantile({30.0, 10.0, 20.0, 40.0}, 1.0), 40.0);
  EXPECT_EQ(Quantile({7.0}, 0.9), 7.0);
  EXPECT_TRUE(std::isnan(Quantile({}, 0.5)));
}

TEST(QuantileOfRepeatedTest, EqualsTheQuantileOfRepeatedValues) {
  const std::vector<double> values = {1.0, 2.0, 4.0, 8.0};
  const std::vector<int64_t> upto = {2, 2, 5, 6};
  const std::vector<double> repeated = {1.0, 1.0, 4.0, 4.0, 4.0, 8.0};
  for (const double q : {0.0, 0.1, 0.2, 0.3, 0.5, 0.77, 0.9, 0.99, 1.0}) {
    EXPECT_DOUBLE_EQ(QuantileOfRepeated(values, upto, q), Quantile(repeated, q))
        << q;
  }
  EXPECT_TRUE(std::isnan(QuantileOfRepeated(values, {0, 0, 0, 0}, 0.5)));
  EXPECT_TRUE(std::isnan(QuantileOfRepeated({}, {}, 0.5)));
}

// ---- Intervals

RatioSeries Series(const std::vector<double>& values) {
  RatioSeries series;
  for (const double value : values) series.push_back({value, 1.0});
  return series;
}

BootstrapOptions Drawing(int64_t block_length, int64_t resamples) {
  BootstrapOptions options;
  options.block_length = block_length;
  options.resamples = resamples;
  return options;
}

// A stationary series with correlation rho from one value to the next.
std::vector<double> CorrelatedSeries(int count, double rho, uint64_t seed) {
  Random random(seed);
  std::vector<double> values;
  double value = random.Normal();
  for (int i = 0; i < count; ++i) {
    values.push_back(value);
    value = rho * value + std::sqrt(1.0 - rho * rho) * random.Normal();
  }
  return values;
}

TEST(BootstrapTest, IndependentValuesGiveAnalyticStandardError) {
  const std::vector<double> values = CorrelatedSeries(400, 0.0, 7);
  const Interval interval =
      RatioInterval(MeanOfRatios, {Series(values)}, Drawing(1, 4000));
  // If single values are resampled, the standard error is exactly s / sqrt(n)
  // up to the random variation of the resamples, 1 / sqrt(2 * 4000) = 1.1 %;
  // the tolerance is five times that.
  const double expected = StandardDeviation(values) / std::sqrt(400.0);
  EXPECT_NEAR(interval.standard_error / expected, 1.0, 0.056);
  // A 95 % interval of a normal mean is +-1.96 standard errors. A quantile at
  // 2.5 % from 4000 draws has an error of sqrt(.025 * .975 / 4000) / density
  // (.0584) = 4.2 % of a standard error; the tolerance is five times that for
  // both ends.
  EXPECT_NEAR((interval.high - interval.low) / expected, 2 * 1.96, 0.30);
}

TEST(BootstrapTest, BlocksIncludeTheCorrelationOfNeighbours) {
  constexpr double kRho = 0.6;
  const std::vector<double> values = CorrelatedSeries(20000, kRho, 8);
  const Interval interval =
      RatioInterval(MeanOfRatios, {Series(values)}, Drawing(25, 1000));
  // Variance of the mean of n values: (1 + rho) / (1 - rho) / n = 4 / n. Blocks
  // of L = 25 values find (1 + 2 sum (1 - k / L) rho^k) / n = 3.7 / n, i.e.
  // 0.925 of that. The 800 blocks contribute sqrt(2 / 800) / 2 = 2.5 % of
  // variation of the standard error, the resamples 2.2 %; together 3.4 %; the
  // tolerance is four times that.
  double expected = 1.0;
  for (int k = 1; k < 25; ++k) {
    expected += 2.0 * (1.0 - k / 25.0) * std::pow(kRho, k);
  }
  const double standard_error = std::sqrt(expected / 20000.0);
  EXPECT_NEAR(interval.standard_error / standard_error, 1.0, 0.14);

  // Resampling single values underestimates the standard error by a factor of
  // two.
  EXPECT_LT(RatioInterval(MeanOfRatios, {Series(values)}, Drawing(1, 1000))
                .standard_error,
            0.6 * standard_error);
}

TEST(BootstrapTest, ResamplesHaveTheSizeOfTheData) {
  int resamples = 0;
  BlockBootstrap({60, 7, 1, 0}, [&](const DrawCounts& counts) {
    ++resamples;
    const auto sixty = counts.begin() + 60;
    EXPECT_EQ(counts.size(), 68u);
    EXPECT_EQ(std::accumulate(counts.begin(), sixty, 0), 60);
    EXPECT_EQ(std::accumulate(sixty, sixty + 7, 0), 7);
    EXPECT_EQ(counts[67], 1);
    return 0.0;
  });
  EXPECT_EQ(resamples, BootstrapOptions().resamples);
}

TEST(BootstrapTest, DrawsEveryUnitEquallyOften) {
  std::vector<double> drawn(30, 0.0);
  BlockBootstrap(
      {30},
      [&](const DrawCounts& counts) {
        for (size_t i = 0; i < counts.size(); ++i) {
          drawn[i] += static_cast<double>(counts[i]);
        }
        return 0.0;
      },
      Drawing(25, 20000));
  // A unit is in the block of 25 with probability 25/30 and in the remaining 5
  // with 5/30: variance 0.278 per resample, so the mean of 1 has a standard
  // error of sqrt(0.278 / 20000) = 0.0037; the tolerance is five times that.
  for (const double times : drawn) EXPECT_NEAR(times / 20000.0, 1.0, 0.019);
}

TEST(BootstrapTest, AShortSeriesHasALargeStandardError) {
  RatioSeries series(20, {0.0, 1.0});
  for (size_t i = 0; i < 10; ++i) series[i].sum = 1.0;
  EXPECT_GT(RatioInterval(MeanOfRatios, {series}).standard_error, 0.1);
}

TEST(BootstrapTest, SameSeedSameInterval) {
  const std::vector<double> values = CorrelatedSeries(100, 0.5, 9);
  const Interval first = RatioInterval(MeanOfRatios, {Series(values)});
  const Interval second = RatioInterval(MeanOfRatios, {Series(values)});
  EXPECT_EQ(first.low, second.low);
  EXPECT_EQ(first.high, second.high);
  BootstrapOptions other;
  other.seed = 2;
  EXPECT_NE(RatioInterval(MeanOfRatios, {Series(values)}, other).low,
            first.low);
}

TEST(BootstrapTest, NoUnitsGiveNaN) {
  EXPECT_TRUE(std::isnan(RatioInterval(MeanOfRatios, {}).low));
  EXPECT_TRUE(std::isnan(RatioInterval(MeanOfRatios, {{}, {}}).standard_error));
  // Units without weight: the score is not a number in any resample.
  EXPECT_TRUE(std::isnan(RatioInterval(MeanOfRatios, {{{0.0, 0.0}}}).high));
  EXPECT_TRUE(std::isnan(MeanOfRatios({})));
}

TEST(BootstrapTest, MeanOfRatiosWeighsSeriesEqually) {
  // A series of one frame and one of four: the mean of 100 % and 25 %.
  EXPECT_DOUBLE_EQ(
      MeanOfRatios({Series({1.0}), Series({1.0, 0.0, 0.0, 0.0}), {}}), 0.625);
}

TEST(PairedDifferenceTest, AConstantDifferenceHasNoSpread) {
  const std::vector<double> b = CorrelatedSeries(200, 0.8, 10);
  std::vector<double> a = b;
  for (double& value : a) value += 0.25;
  // One series each: the mean of ratios is the pooled ratio.
  for (const RatioScore score : {MeanOfRatios, PooledRatio}) {
    const Interval interval = PairedInterval(score, {Series(a)}, {Series(b)});
    // In every resample the difference is 0.25 up to rounding of sums of 200.
    EXPECT_NEAR(interval.low, 0.25, 1e-12);
    EXPECT_NEAR(interval.high, 0.25, 1e-12);
    EXPECT_THROW(PairedInterval(score, {Series({1.0})}, {Series({1.0, 2.0})}),
                 OptionError);
  }
  // Unpaired means have a larger error.
  EXPECT_GT(RatioInterval(MeanOfRatios, {Series(b)}).standard_error, 0.1);
}

TEST(PooledRatio, AddsUpUnitsOfAllSeries) {
  const std::vector<RatioSeries> series = {{{1.0, 1.0}, {5.0, 2.0}},
                                           {{0.0, 0.0}, {4.0, 1.0}}};
  EXPECT_DOUBLE_EQ(PooledRatio(series), 10.0 / 4.0);
  EXPECT_TRUE(std::isnan(PooledRatio({})));
}

}  // namespace
}  // namespace kinegraph
