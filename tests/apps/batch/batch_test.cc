// Recordings x configurations: isolation, resuming, merging.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/batch/merge.h"
#include "tests/apps/batch/study.h"

namespace kinegraph::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

// The plain configuration, and one with a changed key.
const std::vector<std::string> kPlainAndWide = {"",
                                                "reconstruction.alpha_epi=40"};

TEST(BatchTest, FailedTaskDoesNotStopOthers) {
  const BatchStudy study(kPlainAndWide,
                         "[[takes]]\nname = \"bad\"\ncameras = "
                         "\"take1/cameras.json\"\ndetections = "
                         "\"none.jsonl\"\n");
  const std::string out = study.Path("out");
  const ProgramOutcome outcome =
      RunProgram("batch", study.Flags("out", "--jobs=2"));
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.errors, HasSubstr("2 of 6 tasks failed"));
  for (const char* task : {"take1/c0", "take1/c1", "take2/c0", "take2/c1"}) {
    for (const char* file : {"tracks.jsonl", "evaluation.json", "task.json"}) {
      EXPECT_TRUE(fs::exists(out + "/" + task + "/" + file)) << task << file;
    }
  }
  EXPECT_THAT(ContentOf(out + "/bad/c0.failed.txt"), HasSubstr("none.jsonl"));
  EXPECT_FALSE(fs::exists(out + "/bad/c0"));
  const std::string tables = ContentOf(out + "/batch.md");
  EXPECT_THAT(tables, HasSubstr("4 of 6 tasks done"));
  EXPECT_THAT(tables, HasSubstr("- bad/c1: kinegraph-track: error:"));
  EXPECT_THAT(ContentOf(out + "/index.html"),
              HasSubstr("href=\"take2/c1/tracks.jsonl\""));
}

TEST(BatchTest, ResumeSkipsFinishedTasks) {
  const BatchStudy study(kPlainAndWide);
  const std::string out = study.Path("out");
  Done("batch", study.Flags("out"));
  const std::string tables = ContentOf(out + "/batch.json");
  const auto first_time = fs::last_write_time(out + "/take1/c0/task.json");
  Refusal("batch", study.Flags("out"));  // without --resume
  fs::remove_all(out + "/take2/c1");
  const std::string said = Done("batch", study.Flags("out", "--resume")).output;
  EXPECT_THAT(said, HasSubstr("take2/c1 done"));
  EXPECT_THAT(said, Not(HasSubstr("take1")));
  EXPECT_EQ(fs::last_write_time(out + "/take1/c0/task.json"), first_time);
  EXPECT_EQ(ContentOf(out + "/batch.json"), tables);
}

TEST(BatchTest, SingleTasksEqualTheWholeBatchByteForByte) {
  const BatchStudy study(kPlainAndWide);
  Done("batch", study.Flags("all", "--jobs=3"));
  for (const std::string task : {"3", "take1/c1", "0", "2"}) {
    Done("batch", study.Flags("single", "--task=" + task));
  }
  EXPECT_FALSE(fs::exists(study.Path("single/batch.md")));
  // The manifest is stored with the results.
  Done("batch", "--merge --out=" + study.Path("single"));
  study.ExpectSameFiles("all", "single");
}

TEST(BatchTest, ResumeRefusesResultsOfOtherSettings) {
  const BatchStudy study(kPlainAndWide);
  Done("batch", study.Flags("out"));
  std::string text = ContentOf(study.manifest);
  text.replace(text.find("alpha_epi=40"), 12, "alpha_epi=41");
  std::ofstream(study.manifest) << text;
  EXPECT_THAT(
      Refusal("batch", study.Flags("out", "--resume")),
      HasSubstr(
          "take1/c1: is not the result of this task, or was made from other"));
  EXPECT_TRUE(fs::exists(study.Path("out/take1/c1/tracks.jsonl")));
}

TEST(BatchTest, ResumesAKilledBatch) {
  const BatchStudy study(kPlainAndWide);
  Done("batch", study.Flags("whole"));
  const std::string out = study.Path("killed");
  {
    RunningProgram program(
        {ProgramPath("batch"), "--manifest=" + study.manifest, "--out=" + out,
         "--jobs=1"},
        study.Path("errors"));
    ASSERT_TRUE(
        WaitUntil([&] { return fs::exists(out + "/take1/c0/task.json"); }));
    program.Signal(SIGTERM);
    const int status = program.Wait();
    EXPECT_TRUE(WIFSIGNALED(status) || WEXITSTATUS(status) == 0);
  }
  EXPECT_FALSE(HasPartial(out + "/take1"));
  Done("batch", study.Flags("killed", "--resume"));
  study.ExpectSameFiles("whole", "killed");
}

TEST(BatchTest, RefusesManifestsWithMistakes) {
  const TemporaryFolder folder;
  const auto error_of = [&](const std::string& text) {
    return Refusal("batch", "--manifest=" + folder.Write("m.toml", text) +
                                " --out=" + (folder.path() / "out").string());
  };
  EXPECT_THAT(error_of(""), HasSubstr("has no [[takes]]"));
  EXPECT_THAT(error_of("takes = 3"), HasSubstr("expected an array"));
  EXPECT_THAT(error_of("colour = 3"), HasSubstr("'colour'"));
  const std::string recording =
      "[[takes]]\nname = \"a\"\ncameras = \"c\"\ndetections = \"d\"\n";
  EXPECT_THAT(error_of(recording), HasSubstr("has no [[configurations]]"));
  EXPECT_THAT(error_of(recording + recording), HasSubstr("'a' is given twice"));
  EXPECT_THAT(error_of(recording + "protocol = \"mpjpe\"\n"),
              HasSubstr("must be given together"));
  EXPECT_THAT(error_of("[[takes]]\nname = \"../a\"\ncameras = \"c\"\n"
                       "detections = \"d\"\n"),
              HasSubstr("cannot be the name of a file"));
  EXPECT_FALSE(fs::exists(folder.path() / "out"));
}

TEST(BatchTest, FindsShippedConfigurations) {
  const BatchStudy study({""});
  std::string text = ContentOf(study.manifest);
  const std::string path =
      ProjectFile("configs/synthetic/track_paper.toml").string();
  text.replace(text.find(path), path.size(),
               "configs/synthetic/track_paper.toml");
  study.folder.Write("study.toml", text);
  Done("batch", study.Flags("out"));
  EXPECT_TRUE(fs::exists(study.Path("out/take1/c0/tracks.jsonl")));
  text.replace(text.find("track_paper"), 11, "track_paepr");
  study.folder.Write("study.toml", text);
  EXPECT_THAT(Refusal("batch", study.Flags("other")),
              HasSubstr("study.toml: configuration 'c0': its config "));
  EXPECT_FALSE(fs::exists(study.Path("other")));
}

TEST(BatchTest, TablesHaveTheScoresOfPanoptic) {
  const BatchStudy study({""});
  std::string text = ContentOf(study.manifest);
  for (size_t at = 0; (at = text.find("\"mpjpe\"")) != std::string::npos;) {
    text.replace(at, 7, "\"panoptic\"");
  }
  study.folder.Write("study.toml", text);
  Done("batch", study.Flags("out"));
  const Json result = Json::parse(
      ContentOf(study.Path("out/take1/c0/evaluation.json")))["result"];
  const std::string csv = ContentOf(study.Path("out/batch.csv"));
  const auto expect_row = [&csv](const std::string& measure, double value) {
    const std::string row = "take1,c0," + measure + ",";
    const size_t at = csv.find(row);
    ASSERT_NE(at, std::string::npos) << measure;
    EXPECT_NEAR(std::stod(csv.substr(at + row.size())), value, 1e-9 * value);
  };
  expect_row("panoptic_mpjpe_mm", 1e3 * result["mpjpe_m"].get<double>());
  const Json& last = result["thresholds"].back();
  EXPECT_EQ(last["threshold_m"], 0.15);
  expect_row("ap150_percent", 100.0 * last["average_precision"].get<double>());
}

TEST(BatchSummaryTest, ResamplesRecordings) {
  // Two recordings without individual errors: the mean of two draws is 0, 1 or
  // 2 with probabilities 1/4, 1/2 and 1/4, so the 95 % interval is the whole
  // range.
  const BatchColumn column = {BatchValue{0.0, 0.0}, std::nullopt,
                              BatchValue{2.0, 0.0}};
  const BatchSummary summary = Summarise(column);
  EXPECT_EQ(summary.recordings, 2);
  EXPECT_DOUBLE_EQ(summary.mean, 1.0);
  EXPECT_DOUBLE_EQ(summary.interval.low, 0.0);
  EXPECT_DOUBLE_EQ(summary.interval.high, 2.0);
}

TEST(BatchSummaryTest, ResamplesWithinARecording) {
  // One recording: only its own standard error counts. 2000 draws place the 2.5
  // % points of a normal distribution with a standard error of 0.06 sigma
  // (order statistics: sqrt(p (1 - p) / n) over the density there); the
  // tolerance is four times that.
  const BatchSummary summary = Summarise({BatchValue{10.0, 3.0}});
  EXPECT_NEAR(summary.interval.low, 10.0 - 1.96 * 3.0, 4 * 0.06 * 3.0);
  EXPECT_NEAR(summary.interval.high, 10.0 + 1.96 * 3.0, 4 * 0.06 * 3.0);
}

TEST(BatchSummaryTest, PairsDifferencesByRecording) {
  // A constant difference has no uncertainty, however much the recordings
  // differ.
  const BatchColumn a = {BatchValue{1.0, 0.0}, BatchValue{100.0, 0.0}};
  const BatchColumn b = {BatchValue{2.0, 0.0}, BatchValue{101.0, 0.0}};
  const BatchSummary summary = SummariseDifference(a, b);
  EXPECT_DOUBLE_EQ(summary.mean, -1.0);
  EXPECT_DOUBLE_EQ(summary.interval.low, -1.0);
  EXPECT_DOUBLE_EQ(summary.interval.high, -1.0);
  EXPECT_EQ(SummariseDifference(a, {}).recordings, 0);
}

}  // namespace
}  // namespace kinegraph::testing
