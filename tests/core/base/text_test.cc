#include "core/base/text.h"

#include <gtest/gtest.h>

namespace kinegraph {
namespace {

TEST(EditDistanceTest, CountsInsertionsDeletionsAndReplacements) {
  EXPECT_EQ(EditDistance("", ""), 0u);
  EXPECT_EQ(EditDistance("sigma", "sigma"), 0u);
  EXPECT_EQ(EditDistance("", "tau"), 3u);
  EXPECT_EQ(EditDistance("tau", ""), 3u);
  EXPECT_EQ(EditDistance("alpha", "alpha_2d"), 3u);
  EXPECT_EQ(EditDistance("kitten", "sitting"), 3u);  // two replaced, one more
  EXPECT_EQ(EditDistance("ab", "ba"), 2u) << "a swap counts twice";
}

}  // namespace
}  // namespace kinegraph
