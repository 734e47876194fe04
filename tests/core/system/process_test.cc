#include "core/system/process.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <stdexcept>

namespace kinegraph {
namespace {

constexpr int kLimit_s = 60;

TEST(RehearseTest, NothingOfItStays) {
  int number = 1;
  EXPECT_TRUE(Rehearse([&] { number = 2; }, kLimit_s).well());
  EXPECT_EQ(number, 1);
}

TEST(RehearseTest, AnExceptionEndsItWell) {
  EXPECT_TRUE(
      Rehearse([] { throw std::runtime_error("refused"); }, kLimit_s).well());
}

TEST(RehearseTest, TellsWhatBroughtItDown) {
  EXPECT_EQ(Rehearse([] { raise(SIGKILL); }, kLimit_s).signal, SIGKILL);
  EXPECT_FALSE(Rehearse([] { std::abort(); }, kLimit_s).well());
  EXPECT_EQ(Rehearse([] { _exit(3); }, kLimit_s).code, 3);
}

TEST(RehearseTest, EndsWhatDoesNotEnd) {
  const volatile bool for_ever = true;
  EXPECT_NE(Rehearse(
                [&] {
                  while (for_ever) {
                  }
                },
                1)
                .signal,
            0);
}

}  // namespace
}  // namespace kinegraph
