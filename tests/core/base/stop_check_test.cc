#include "core/base/stop_check.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "core/base/parallel.h"

namespace kinegraph {
namespace {

TEST(StopCheckTest, NobodyStopsWithoutAScope) {
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

// The caller has nothing left to do, and others work on.
TEST(StopCheckTest, IsHeardWhileWaiting) {
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
