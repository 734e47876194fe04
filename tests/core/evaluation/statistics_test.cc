#include "core/evaluation/statistics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace kinegraph {
namespace {

TEST(ShareTest, HasNoFractionOfNothing) {
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

TEST(StatisticsTest, MeanAndSpread) {
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

}  // namespace
}  // namespace kinegraph
