#include "apps/tables/sensitivity.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

TEST(SweepValuesTest, GoFromHalfToTwiceWithTheValueInTheMiddle) {
  const std::vector<double> values = SweepValues(60.0, 1e9);
  ASSERT_EQ(values.size(), 9u);
  EXPECT_DOUBLE_EQ(values.front(), 30.0);
  EXPECT_DOUBLE_EQ(values[4], 60.0);
  EXPECT_DOUBLE_EQ(values.back(), 120.0);
  // Equal steps of the logarithm: a quarter of an octave.
  EXPECT_NEAR(values[1] / values[0], std::exp2(0.25), 1e-12);
}

TEST(SweepValuesTest, AreCutAtWhatTheKeyAllows) {
  const std::vector<double> values = SweepValues(10.0, 17.0);
  EXPECT_DOUBLE_EQ(values.back(), 17.0);
  for (size_t i = 1; i < values.size(); ++i)
    EXPECT_GT(values[i], values[i - 1]);
}

TEST(SweptParametersTest, SetWhatTheyGet) {
  ASSERT_EQ(SweptParameters().size(), 5u);
  for (const SweptParameter& parameter : SweptParameters()) {
    TrackerOptions options;
    const double value = parameter.get(options);
    parameter.set(1.5 * value, &options);
    EXPECT_DOUBLE_EQ(parameter.get(options), 1.5 * value) << parameter.name;
    CheckOptions(options);
  }
}

TEST(SweptParametersTest, AlphaEpiKeepsTheRatiosOfInitialisation) {
  TrackerOptions options;
  options.reconstruction.alpha_epi_px = 60.0;
  options.initialisation.alpha_group_px = 60.0;
  options.initialisation.alpha_filter_px = 30.0;
  SweptParameters()[1].set(120.0, &options);
  EXPECT_DOUBLE_EQ(options.initialisation.alpha_group_px, 120.0);
  EXPECT_DOUBLE_EQ(options.initialisation.alpha_filter_px, 60.0);
}

TEST(SweepsTest, ThePublishedValueDiffersFromItselfByNothing) {
  KINEGRAPH_DATA_OR_SKIP(data, "shelf/detections/openpose");
  Benchmark benchmark =
      FindBenchmarks(testing::FindData("")->string()).benchmarks.front();
  benchmark.recordings.resize(1);
  const std::vector<Sweep> sweeps =
      RunSensitivity(benchmark, testing::FindData("")->string(), "", [] {});
  ASSERT_EQ(sweeps.size(), 5u);
  for (const Sweep& sweep : sweeps) {
    const SweptValue& published = sweep.values[4];
    EXPECT_DOUBLE_EQ(published.value, sweep.paper_value) << sweep.parameter;
    EXPECT_EQ(published.difference, 0.0);
    EXPECT_EQ(published.difference_interval.low, 0.0);
    EXPECT_EQ(published.difference_interval.high, 0.0);
  }
  // lambda_a scales a whole row of the affinities and so hardly decides.
  for (const SweptValue& value : sweeps[4].values) {
    EXPECT_NEAR(value.difference, 0.0, 0.5);
  }
  EXPECT_EQ(SensitivityPlots(sweeps).size(), 5u);
}

}  // namespace
}  // namespace kinegraph
