#include "core/base/weighted_quantile.h"

#include <gtest/gtest.h>

namespace kinegraph {
namespace {

TEST(WeightedQuantile, TheLeastValueThatReachesTheShare) {
  const std::vector<WeightedValue> values = {
      {3.0, 1.0}, {1.0, 2.0}, {2.0, 1.0}};
  EXPECT_EQ(WeightedQuantile(values, 0.0), 1.0);
  EXPECT_EQ(WeightedQuantile(values, 0.5), 1.0);
  EXPECT_EQ(WeightedQuantile(values, 0.51), 2.0);
  EXPECT_EQ(WeightedQuantile(values, 0.75), 2.0);
  EXPECT_EQ(WeightedQuantile(values, 1.0), 3.0);
}

TEST(WeightedQuantile, TheMedianLiesBetweenTwoHalves) {
  EXPECT_EQ(WeightedMedian({{7.0, 1.0}}), 7.0);
  // Even: the mean of the middle two, as without weights.
  EXPECT_EQ(WeightedMedian({{1.0, 1.0}, {2.0, 1.0}, {4.0, 1.0}, {9.0, 1.0}}),
            3.0);
  EXPECT_EQ(WeightedMedian({{1.0, 1.0}, {2.0, 1.0}, {9.0, 1.0}}), 2.0);
  // Half of the weight is the first value's.
  EXPECT_EQ(WeightedMedian({{1.0, 2.0}, {2.0, 1.0}, {4.0, 1.0}}), 1.5);
  EXPECT_EQ(WeightedMedian({{1.0, 3.0}, {2.0, 1.0}, {4.0, 1.0}}), 1.0);
}

// A weight of nothing changes nothing.
TEST(WeightedQuantile, ValuesWithoutWeightDoNotCount) {
  const std::vector<WeightedValue> values = {
      {1.0, 1.0}, {2.0, 1.0}, {3.0, 1.0}};
  std::vector<WeightedValue> more = values;
  more.emplace_back(50.0, 0.0);
  EXPECT_EQ(WeightedMedian(more), WeightedMedian(values));
  EXPECT_EQ(WeightedQuantile(more, 1.0), 3.0);
}

}  // namespace
}  // namespace kinegraph
