#include "apps/tables/ablation.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "apps/tables/dataset.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

// The bars are the table's differences, and their error bars its intervals.
TEST(AblationPlotsTest, ShowTheDifferencesOfTheTable) {
  KINEGRAPH_DATA_OR_SKIP(data, "shelf/reference/filled_coco17");
  const LoadedDataset loaded =
      LoadDataset(ShelfFilled(), testing::FindData("")->string());
  const std::vector<AblationCell> cells = RunAblation(loaded);
  ASSERT_EQ(cells.size(), 4u);
  const std::vector<Plot> panels =
      AblationPlots({{"first", cells}, {"second", cells}});
  ASSERT_EQ(panels.size(), 2u);  // the headline, lower arms
  EXPECT_EQ(panels[0].x.categories,
            (std::vector<std::string>{"first", "second"}));
  ASSERT_EQ(panels[0].series.size(), 3u);
  for (size_t s = 0; s < 3; ++s) {
    const PlotSeries& bars = panels[0].series[s];
    const AblationCell& cell = cells[s + 1];
    EXPECT_EQ(bars.x, (std::vector<double>{0.0, 1.0}));
    EXPECT_EQ(bars.y, std::vector<double>(2, cell.difference));
    EXPECT_EQ(bars.y_low, std::vector<double>(2, cell.difference_interval.low));
    EXPECT_EQ(bars.y_high,
              std::vector<double>(2, cell.difference_interval.high));
    // The filter mends lower arms on filled detections (docs/results.md).
    EXPECT_NE(panels[1].series[s].y, bars.y);
  }
  EXPECT_EQ(panels[0].series[0].name, "body-aware, joints filter");
}

}  // namespace
}  // namespace kinegraph
