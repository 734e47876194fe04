#include <gtest/gtest.h>

#include <cstdlib>

#include "core/io/adapters/adapter.h"
#include "tests/support/test_data.h"

namespace {

// Every test starts from the same state of the C library's generator; the
// project's own generator (core/base/random.h) is seeded where it is made.
class SeedBeforeEachTest : public ::testing::EmptyTestEventListener {
  void OnTestStart(const ::testing::TestInfo&) override { std::srand(1); }
};

}  // namespace

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  // Adapters are built beside the commands, not beside this program.
  const auto adapters =
      kinegraph::testing::BuildFile("apps/kinegraph-adapters");
  kinegraph::SetOwnAdapters({adapters.string()});
  ::testing::UnitTest::GetInstance()->listeners().Append(
      new SeedBeforeEachTest);
  return RUN_ALL_TESTS();
}
