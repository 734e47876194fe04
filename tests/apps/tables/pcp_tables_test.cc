#include "apps/tables/pcp_tables.h"

#include <gtest/gtest.h>

#include "core/io/tracks/tracks.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

TEST(FrameRunsTest, MergesConsecutiveFramesAndCountsTheRest) {
  EXPECT_EQ(FrameRuns({}, 3), "");
  EXPECT_EQ(FrameRuns({7}, 3), "7");
  EXPECT_EQ(FrameRuns({300, 301, 302, 410, 412, 413}, 3),
            "300-302, 410, 412-413");
  EXPECT_EQ(FrameRuns({1, 3, 4, 6, 8, 9}, 2), "1, 3-4 and 3 more");
}

// Two results with known scores, in a benchmark made for this test.
TEST(ActorTableTest, ShowsPublishedAndMeasuredRowsWithCounts) {
  KINEGRAPH_DATA_OR_SKIP(data, "shelf");
  TrackedBenchmark tracked;
  tracked.truth = ReadTracks(data + "/tum/actorsGT.mat");
  TrackedRow base;
  base.method = "warm";
  base.recording = "a recording";
  base.ours = true;
  base.baseline = true;
  base.tracks = ReadTracks(data + "/reference/paper_code_shelf_warm3.json");
  TrackedRow other = base;
  other.method = "no filter";
  other.baseline = false;
  other.tracks =
      ReadTracks(data + "/reference/paper_code_shelf_warm3_nojf_conf.json");
  tracked.rows = {base, other};
  const TableOutput table =
      ActorTable("Shelf", PublishedShelf(), tracked, ShelfProtocol());
  for (const char* text : {"Chu et al.", "97.39", "99.71 (2782/2790)",
                           "94.32 (349/370)", "97.64 (1572/1610)", "97.23 ["}) {
    EXPECT_NE(table.markdown.find(text), std::string::npos) << text;
  }
  const Json& measured = table.json["measured"];
  ASSERT_EQ(measured.size(), 2u);
  // Five head conversions times two endpoint rules (data/shelf/reference).
  ASSERT_EQ(measured[0]["scores"].size(), 10u);
  EXPECT_EQ(measured[0]["scores"][0]["head"], "chu");
  EXPECT_EQ(measured[0]["scores"][0]["endpoints"], "mean");
  EXPECT_EQ(measured[0]["scores"][0]["actors"]["0"]["right"], 2782);
  EXPECT_NEAR(measured[0]["scores"][1]["mean_of_actors"].get<double>(), 93.14,
              0.005);
  // Known: the filter improves the score by 0.74 under chu. Both scores are
  // rounded to 0.01.
  EXPECT_NEAR(measured[1]["scores"][0]["difference"].get<double>(),
              96.49 - 97.23, 0.01);
  // Every lost part has one reason.
  const Json& actor = measured[1]["scores"][0]["actors"]["2"];
  int64_t reasons = 0;
  for (const Json& count : actor["lost_because"]) {
    reasons += count.get<int64_t>();
  }
  EXPECT_EQ(reasons,
            actor["parts"].get<int64_t>() - actor["right"].get<int64_t>());
}

}  // namespace
}  // namespace kinegraph
