#include "apps/tables/rows.h"

#include <gtest/gtest.h>

#include <string>

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

// What the authors' code makes of real detections, whose zeros it takes for
// positions: 71.37 warmed up, 71.04 from frame 300 on (docs/paper_mode.md).
TEST(KnownRowsTest, TheAuthorsCodeOnRealDetections) {
  KINEGRAPH_DATA_OR_SKIP(data, "shelf/detections/openpose");
  const std::string root = testing::FindData("")->string();
  Benchmark shelf = FindBenchmarks(root).benchmarks.front();
  ASSERT_EQ(shelf.set, BenchmarkSet::kShelf);
  BenchmarkRecording recording = shelf.recordings.front();
  recording.methods = {
      {"warm", "paper/shelf_authors_code.toml", "input.repeat_first_frame=3"},
      {"cold", "paper/shelf_authors_code.toml", ""}};
  shelf.recordings = {recording};
  shelf.results.clear();
  shelf.single_person.clear();
  const TrackedBenchmark tracked = TrackBenchmark(shelf, root, "", [] {});
  ASSERT_EQ(tracked.rows.size(), 2u);
  const auto mean = [&](const TrackedRow& row) {
    return MeanOfActors(EvaluatePcp(tracked.truth, row.tracks, ShelfProtocol()),
                        PcpGroup::kTotal);
  };
  // Two decimals: half a unit.
  EXPECT_NEAR(mean(tracked.rows[0]), 71.37, 0.005 + 1e-9);
  EXPECT_NEAR(mean(tracked.rows[1]), 71.04, 0.005 + 1e-9);
  // 4D association's tracks by its own rules.
  ASSERT_EQ(tracked.own_rules.size(), 2u);
  EXPECT_NEAR(MeanOfActors(tracked.own_rules[0], PcpGroup::kTotal), 96.27,
              0.005 + 1e-9);
  EXPECT_NEAR(MeanOfActors(tracked.own_rules[1], PcpGroup::kTotal), 97.92,
              0.005 + 1e-9);
}

}  // namespace
}  // namespace kinegraph
