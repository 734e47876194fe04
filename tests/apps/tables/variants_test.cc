#include "apps/tables/variants.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using Doubles = std::vector<double>;

// The bars show the differences of the table, the error bars their intervals.
TEST(AblationPlotsTest, ShowTheDifferencesOfTheTable) {
  KINEGRAPH_DATA_OR_SKIP(data, "shelf/reference/filled_coco17");
  const std::vector<AblationCell> cells =
      RunAblation(LoadDataset(ShelfFilled(), testing::FindData("")->string()));
  ASSERT_EQ(cells.size(), 4u);
  const std::vector<Plot> panels =
      AblationPlots({{"first", cells}, {"second", cells}});
  ASSERT_EQ(panels.size(), 2u);  // all parts, lower arms
  EXPECT_EQ(panels[0].x.categories,
            (std::vector<std::string>{"first", "second"}));
  ASSERT_EQ(panels[0].series.size(), 3u);
  for (size_t s = 0; s < 3; ++s) {
    const PlotSeries& bars = panels[0].series[s];
    const PcpDifference& difference = cells[s + 1].difference;
    EXPECT_EQ(bars.x, (Doubles{0.0, 1.0}));
    EXPECT_EQ(bars.y, Doubles(2, difference.value));
    EXPECT_EQ(bars.y_low, Doubles(2, difference.interval.low));
    EXPECT_EQ(bars.y_high, Doubles(2, difference.interval.high));
    // The lower arms have other differences than all parts together.
    EXPECT_NE(panels[1].series[s].y, bars.y);
  }
  EXPECT_EQ(panels[0].series[0].name, "body-aware, joints filter");
}

TEST(SweepValuesTest, GoFromHalfToTwiceWithinTheRangeOfTheKey) {
  const Doubles values = SweepValues(60.0, 1e9);
  ASSERT_EQ(values.size(), 9u);
  EXPECT_DOUBLE_EQ(values.front(), 30.0);
  EXPECT_DOUBLE_EQ(values[4], 60.0);
  EXPECT_DOUBLE_EQ(values.back(), 120.0);
  // Equal steps of the logarithm: a quarter of an octave.
  EXPECT_NEAR(values[1] / values[0], std::exp2(0.25), 1e-12);
  const Doubles cut = SweepValues(10.0, 17.0);
  EXPECT_DOUBLE_EQ(cut.back(), 17.0);
  for (size_t i = 1; i < cut.size(); ++i) EXPECT_GT(cut[i], cut[i - 1]);
}

TEST(SweptParametersTest, SetterAndGetterAgree) {
  ASSERT_EQ(SweptParameters().size(), 5u);
  for (const SweptParameter& parameter : SweptParameters()) {
    TrackerOptions options;
    const double value = parameter.ValueIn(options);
    parameter.Set(1.5 * value, &options);
    EXPECT_EQ(parameter.ValueIn(options), 1.5 * value) << parameter.name;
    CheckOptions(options);
  }
}

TEST(SweptParametersTest, AlphaEpiScalesTheInitialisationThresholds) {
  TrackerOptions options;
  options.reconstruction.alpha_epi_px = 60.0;
  options.initialisation.alpha_group_px = 60.0;
  options.initialisation.alpha_filter_px = 30.0;
  SweptParameters()[1].Set(120.0, &options);
  EXPECT_DOUBLE_EQ(options.initialisation.alpha_group_px, 120.0);
  EXPECT_DOUBLE_EQ(options.initialisation.alpha_filter_px, 60.0);
}

TEST(SweepsTest, ThePublishedValueHasNoDifferenceFromItself) {
  KINEGRAPH_DATA_OR_SKIP(data, "shelf/detections/openpose");
  const LoadedDataset loaded =
      LoadDataset(ShelfReal(), testing::FindData("")->string());
  std::vector<Sweep> sweeps;
  for (const SweptParameter& parameter : SweptParameters()) {
    sweeps.push_back(RunSweep(loaded, parameter));
    const SweptValue& published = sweeps.back().values[4];
    EXPECT_DOUBLE_EQ(published.value, sweeps.back().paper_value)
        << parameter.name;
    EXPECT_EQ(published.difference.value, 0.0);
    EXPECT_EQ(published.difference.interval.low, 0.0);
    EXPECT_EQ(published.difference.interval.high, 0.0);
  }
  // lambda_a multiplies a track's affinities to all detections of a view by the
  // same factor, which has little influence on the assignment: PCP changes by
  // less than half a percentage point.
  for (const SweptValue& value : sweeps.back().values) {
    EXPECT_NEAR(value.difference.value, 0.0, 0.5);
  }
  EXPECT_EQ(SensitivityPlots(sweeps).size(), 5u);
}

}  // namespace
}  // namespace kinegraph
