#include "core/base/byte_queue.h"

#include <gtest/gtest.h>

#include <string>

namespace kinegraph {
namespace {

// Lengths from none to beyond a block of 256 KB.
std::string Thing(size_t number) {
  const size_t length = number % 50 == 49 ? 300'000 : number * 37 % 5000;
  return std::string(length, static_cast<char>('a' + number % 26));
}

TEST(ByteQueue, GivesBackInOrder) {
  ByteQueue queue;
  EXPECT_TRUE(queue.empty());
  for (size_t i = 0; i < 400; ++i) queue.Push(Thing(i));
  EXPECT_EQ(queue.size(), 400u);
  for (size_t i = 0; i < 400; ++i) {
    ASSERT_EQ(queue.front(), Thing(i));
    queue.Pop();
  }
  EXPECT_TRUE(queue.empty());
}

TEST(ByteQueue, IsFilledWhileItIsRead) {
  ByteQueue queue;
  size_t read = 0;
  for (size_t i = 0; i < 300; ++i) {
    queue.Push(Thing(i));
    if (i % 3 == 0) continue;
    ASSERT_EQ(queue.front(), Thing(read++));
    queue.Pop();
  }
  while (!queue.empty()) {
    ASSERT_EQ(queue.front(), Thing(read++));
    queue.Pop();
  }
  EXPECT_EQ(read, 300u);
  queue.Push("and again");
  EXPECT_EQ(queue.front(), "and again");
}

}  // namespace
}  // namespace kinegraph
