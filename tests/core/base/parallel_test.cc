#include "core/base/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <string>
#include <vector>

namespace kinegraph {
namespace {

TEST(ParallelForTest, DoesEachPieceOnce) {
  for (const int threads : {0, 1, 3, 1000}) {
    for (const int count : {0, 1, 2, 100}) {
      std::vector<std::atomic<int>> done(count);
      ParallelFor(threads, count, [&](int i) { ++done[i]; });
      for (int i = 0; i < count; ++i) EXPECT_EQ(done[i], 1);
    }
  }
}

TEST(ParallelForTest, ThrowsWhatTheLowestPieceThrew) {
  // Two pieces fail; with several threads the others are done all the same.
  std::atomic<int> done{0};
  const auto work = [&](int i) {
    if (i == 3 || i == 7) throw std::runtime_error(std::to_string(i));
    ++done;
  };
  try {
    ParallelFor(4, 10, work);
    FAIL() << "nothing was thrown";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "3");
  }
  EXPECT_EQ(done, 8);
}

// A piece may ask for threads of its own, from however many at a time.
TEST(ParallelForTest, MayBeCalledFromAPiece) {
  std::vector<std::atomic<int>> done(20 * 30);
  ParallelFor(4, 20, [&](int outer) {
    ParallelFor(3, 30, [&](int inner) { ++done[30 * outer + inner]; });
  });
  for (const std::atomic<int>& count : done) EXPECT_EQ(count, 1);
}

TEST(ParallelForTest, ThrowsThroughAPiece) {
  const auto outer = [](int i) {
    ParallelFor(2, 10, [&](int j) {
      if (i == 5 && j == 5) throw std::runtime_error("inner");
    });
  };
  EXPECT_THROW(ParallelFor(3, 10, outer), std::runtime_error);
}

TEST(ParallelForTest, TellsAPieceHowManyThreadsItMayAskFor) {
  EXPECT_EQ(AllowedThreads(), 1);
  for (const int threads : {1, 3}) {
    for (const int count : {1, 8}) {
      ParallelFor(threads, count,
                  [&](int) { EXPECT_EQ(AllowedThreads(), threads); });
    }
  }
  EXPECT_EQ(AllowedThreads(), 1);
}

}  // namespace
}  // namespace kinegraph
