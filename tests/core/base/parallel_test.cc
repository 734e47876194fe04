// Work on several threads, and cancellation.
#include "core/base/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "core/base/stop_check.h"

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

TEST(ParallelForTest, RethrowsTheExceptionOfTheLowestPiece) {
  // Two pieces fail; with several threads the others still complete.
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

// Pieces may call ParallelFor themselves, any number at a time.
TEST(ParallelForTest, MayBeCalledFromAPiece) {
  std::vector<std::atomic<int>> done(20 * 30);
  ParallelFor(4, 20, [&](int outer) {
    ParallelFor(3, 30, [&](int inner) { ++done[30 * outer + inner]; });
  });
  for (const std::atomic<int>& count : done) EXPECT_EQ(count, 1);
}

TEST(ParallelForTest, RethrowsTheExceptionOfANestedCall) {
  const auto outer = [](int i) {
    ParallelFor(2, 10, [&](int j) {
      if (i == 5 && j == 5) throw std::runtime_error("inner");
    });
  };
  EXPECT_THROW(ParallelFor(3, 10, outer), std::runtime_error);
}

TEST(ParallelForTest, PiecesSeeTheAllowedNumberOfThreads) {
  EXPECT_EQ(AllowedThreads(), 1);
  for (const int threads : {1, 3}) {
    for (const int count : {1, 8}) {
      ParallelFor(threads, count,
                  [&](int) { EXPECT_EQ(AllowedThreads(), threads); });
    }
  }
  EXPECT_EQ(AllowedThreads(), 1);
}

TEST(StopCheckTest, OnlyTheInnermostScopeIsChecked) {
  CheckStop();
  EXPECT_EQ(CurrentStopCheck(), nullptr);
  int asked = 0;
  const StopCheck outer = [&] { ++asked; };
  const StopCheck inner = [] { throw Stopped(); };
  const StopScope scope(&outer);
  CheckStop();
  {
    const StopScope within(&inner);
    EXPECT_THROW(CheckStop(), Stopped);
  }
  CheckStop();
  EXPECT_EQ(asked, 2);
}

TEST(StopCheckTest, EndsTheWorkOfAllThreads) {
  for (const int threads : {1, 4}) {
    std::atomic<int> done{0};
    const StopCheck check = [&] {
      if (done >= 10) throw Stopped();
    };
    const StopScope scope(&check);
    EXPECT_THROW(ParallelFor(threads, 1000, [&](int) { ++done; }), Stopped);
    EXPECT_GE(done, 10);
    // Each other thread may be in the middle of a piece.
    EXPECT_LE(done, 10 + threads);
  }
}

// The caller has no pieces left while a helper still works: only the check on
// the caller's thread ends the helper's piece.
TEST(StopCheckTest, IsPolledWhileWaiting) {
  const std::thread::id caller = std::this_thread::get_id();
  std::atomic<bool> stopped{false};
  std::atomic<bool> helper_works{false};
  const StopCheck check = [&] {
    if (std::this_thread::get_id() == caller && helper_works) stopped = true;
    if (stopped) throw Stopped();
  };
  const StopScope scope(&check);
  const auto work = [&](int) {
    if (std::this_thread::get_id() == caller) {
      // Leaves the other piece to a helper.
      while (!helper_works) std::this_thread::yield();
      return;
    }
    helper_works = true;
    while (true) {
      CheckStop();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  };
  EXPECT_THROW(ParallelFor(2, 2, work), Stopped);
  EXPECT_TRUE(stopped);
}

}  // namespace
}  // namespace kinegraph
