#include "core/base/growing_blocks.h"

#include <gtest/gtest.h>

namespace kinegraph {
namespace {

TEST(GrowingBlocksTest, GivesBackWhatWasPushedInOrder) {
  GrowingBlocks<int> values;
  EXPECT_TRUE(values.empty());
  constexpr int kCount = 100'000;  // blocks of every size
  for (int i = 0; i < kCount; ++i) {
    values.Push(i);
    ASSERT_EQ(values.back(), i);
  }
  for (int i = 0; i < kCount; ++i) {
    ASSERT_FALSE(values.empty());
    ASSERT_EQ(values.front(), i);
    values.Pop();
  }
  EXPECT_TRUE(values.empty());
}

TEST(GrowingBlocksTest, PushesAndPopsMayAlternate) {
  GrowingBlocks<int> values;
  int popped = 0;
  for (int i = 0; i < 1000; ++i) {
    values.Push(2 * i);
    values.Push(2 * i + 1);
    ASSERT_EQ(values.front(), popped++);
    values.Pop();
  }
  for (; !values.empty(); values.Pop()) ASSERT_EQ(values.front(), popped++);
  EXPECT_EQ(popped, 2000);
  values.Push(7);
  EXPECT_EQ(values.front(), 7);
}

}  // namespace
}  // namespace kinegraph
