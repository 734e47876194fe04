#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "apps/tables/dataset.h"

namespace kinegraph {
namespace {

// The printed average is the unweighted mean of the printed values of the three
// actors. Averages with one decimal are rounded, so the error is at most half a
// unit of the last decimal; some of those with two are truncated (96.797 to
// 96.79), so it is less than a unit. Two averages of the Campus table differ,
// as its caption states.
TEST(PublishedTest, AveragesAreUnweightedMeansOfActors) {
  for (const PublishedTable& table :
       {PublishedCampus(), PublishedCampusExtended(), PublishedShelf()}) {
    for (const PublishedRow& row : table.rows) {
      if (row.cells[0] == "-") continue;
      if (row.cells[0] == "93.5" || row.cells[2] == "92.2") continue;
      const double mean = (std::stod(row.cells[0]) + std::stod(row.cells[1]) +
                           std::stod(row.cells[2])) /
                          3.0;
      const bool two_decimals =
          row.cells[3].size() == 5 && row.cells[0].size() == 5;
      EXPECT_NEAR(std::stod(row.cells[3]), mean,
                  (two_decimals ? 0.01 : 0.05) + 1e-9)
          << table.caption << ": " << row.method;
    }
  }
}

TEST(PublishedTest, EveryRowHasOneCellPerColumn) {
  for (const PublishedTable& table :
       {PublishedCampus(), PublishedCampusExtended(), PublishedShelf(),
        PublishedCampusParts(), PublishedShelfParts(), PublishedRuntime(),
        PublishedAblation()}) {
    for (const PublishedRow& row : table.rows) {
      EXPECT_EQ(row.cells.size(), table.columns.size()) << row.method;
    }
  }
  // The main tables contain all nine methods.
  for (const PublishedTable& table : {PublishedCampus(), PublishedShelf()}) {
    ASSERT_EQ(table.rows.size(), 9u);
    EXPECT_EQ(table.rows.front().method, "Belagiannis et al.");
    EXPECT_EQ(table.rows.back().method, "Chu et al.");
  }
}

// The paper's PCP values are fractions of the parts in the annotated
// person-frames: 279, 37 and 161 on Shelf, 49, 189 and 138 on Campus. So the
// frames and the pooling are those of the protocol.
TEST(PublishedTest, PaperPcpIsAFractionOfAnnotatedParts) {
  struct Row {
    PublishedTable table;
    std::array<int, 3> parts;
    std::array<int, 3> right;
  };
  const std::vector<Row> rows = {
      {PublishedShelf(), {2790, 370, 1610}, {2766, 353, 1572}},
      {PublishedCampus(), {490, 1890, 1380}, {482, 1772, 1356}}};
  for (const Row& row : rows) {
    const PublishedRow& chu = row.table.rows.back();
    for (int actor = 0; actor < 3; ++actor) {
      const double percent = 100.0 * row.right[actor] / row.parts[actor];
      // Two decimals, rounded: half a unit.
      EXPECT_NEAR(std::stod(chu.cells[actor]), percent, 0.005 + 1e-9);
    }
  }
}

}  // namespace
}  // namespace kinegraph
