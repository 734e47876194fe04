#include "apps/tables/rows.h"

#include <gtest/gtest.h>

#include "apps/tables/benchmark.h"
#include "core/base/error.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

TEST(JoinSetsTest, PutsOneAfterTheOther) {
  EXPECT_EQ(JoinSets("", ""), "");
  EXPECT_EQ(JoinSets("a=1", ""), "a=1");
  EXPECT_EQ(JoinSets("", "b=2"), "b=2");
  EXPECT_EQ(JoinSets("a=1", "b=2"), "a=1;b=2");
}

TEST(FindBenchmarksTest, AnEmptyFolderIsRefused) {
  const testing::TemporaryFolder folder;
  EXPECT_THROW(FindBenchmarks(folder.path().string()), InputError);
}

}  // namespace
}  // namespace kinegraph
