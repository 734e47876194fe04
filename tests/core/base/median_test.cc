#include "core/base/median.h"

#include <gtest/gtest.h>

namespace kinegraph {
namespace {

TEST(Median, IsTheMiddleOrTheGreaterOfTwo) {
  EXPECT_EQ(Median({}), 0.0);
  EXPECT_EQ(Median({7.0}), 7.0);
  EXPECT_EQ(Median({9.0, 1.0, 2.0}), 2.0);
  EXPECT_EQ(Median({9.0, 1.0, 4.0, 2.0}), 4.0);
}

}  // namespace
}  // namespace kinegraph
