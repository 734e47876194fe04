// Takes x configurations: isolation, resuming, merging.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/batch/merge.h"
#include "tests/support/faulty_runs.h"

namespace kinegraph::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

// Two short recordings and one whose detections are missing, two
// configurations.
struct Study {
  TemporaryFolder folder;
  std::string manifest;

  explicit Study(bool with_bad_recording) {
    std::string text;
    for (const int seed : {1, 2}) {
      const std::string name = "take" + std::to_string(seed);
      const ProgramOutcome made = RunProgram(
          "synthesize",
          "--config=" + ProjectFile("configs/synthetic/demo.toml").string() +
              " --set='scene.duration=0.4;scene.seed=" + std::to_string(seed) +
              "' --out=" + (folder.path() / name).string());
      EXPECT_EQ(made.exit_code, 0) << made.errors;
      text += "[[takes]]\nname = \"" + name + "\"\ncameras = \"" + name +
              "/cameras.json\"\ndetections = \"" + name +
              "/detections.jsonl\"\nground_truth = \"" + name +
              "/truth.jsonl\"\nprotocol = \"mpjpe\"\n";
    }
    if (with_bad_recording) {
      text +=
          "[[takes]]\nname = \"bad\"\ncameras = \"take1/cameras.json\"\n"
          "detections = \"none.jsonl\"\n";
    }
    const std::string config =
        ProjectFile("configs/synthetic/track_paper.toml").string();
    for (const std::string name : {"plain", "wide"}) {
      text += "[[configurations]]\nname = \"" + name + "\"\nconfig = \"" +
              config + "\"\n";
      if (name == "wide") text += "set = \"reconstruction.alpha_epi=40\"\n";
    }
    manifest = folder.Write("study.toml", text);
  }

  std::string Out(const std::string& name) const {
    return (folder.path() / name).string();
  }
  ProgramOutcome Run(const std::string& out, const std::string& more) const {
    return RunProgram("batch",
                      "--manifest=" + manifest + " --out=" + out + " " + more);
  }
};

TEST(BatchTest, OneFailureStopsNobodyElse) {
  const Study study(true);
  const std::string out = study.Out("out");
  const ProgramOutcome outcome = study.Run(out, "--jobs=2");
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.errors, HasSubstr("2 of 6 tasks failed"));
  for (const char* task :
       {"take1/plain", "take1/wide", "take2/plain", "take2/wide"}) {
    EXPECT_TRUE(fs::exists(out + "/" + task + "/tracks.jsonl")) << task;
    EXPECT_TRUE(fs::exists(out + "/" + task + "/evaluation.json")) << task;
    EXPECT_TRUE(fs::exists(out + "/" + task + "/task.json")) << task;
  }
  EXPECT_THAT(ContentOf(out + "/bad/plain.failed.txt"),
              HasSubstr("none.jsonl"));
  EXPECT_FALSE(fs::exists(out + "/bad/plain"));
  const std::string tables = ContentOf(out + "/batch.md");
  EXPECT_THAT(tables, HasSubstr("4 of 6 tasks done"));
  EXPECT_THAT(tables, HasSubstr("- bad/wide: kinegraph-track: error:"));
  EXPECT_THAT(ContentOf(out + "/index.html"),
              HasSubstr("href=\"take2/wide/tracks.jsonl\""));
}

TEST(BatchTest, DoesNotDoAgainWhatIsDone) {
  const Study study(false);
  const std::string out = study.Out("out");
  ASSERT_EQ(study.Run(out, "").exit_code, 0);
  const std::string tables = ContentOf(out + "/batch.json");
  const auto first_time = fs::last_write_time(out + "/take1/plain/task.json");
  EXPECT_EQ(study.Run(out, "").exit_code, 2);  // without --resume
  fs::remove_all(out + "/take2/wide");
  const ProgramOutcome resumed = study.Run(out, "--resume");
  EXPECT_EQ(resumed.exit_code, 0) << resumed.errors;
  EXPECT_THAT(resumed.output, HasSubstr("take2/wide done"));
  EXPECT_THAT(resumed.output, Not(HasSubstr("take1")));
  EXPECT_EQ(fs::last_write_time(out + "/take1/plain/task.json"), first_time);
  EXPECT_EQ(ContentOf(out + "/batch.json"), tables);
}

TEST(BatchTest, OneByOneEqualsAllAtOnceByteForByte) {
  const Study study(false);
  const std::string all = study.Out("all");
  const std::string single = study.Out("single");
  ASSERT_EQ(study.Run(all, "--jobs=3").exit_code, 0);
  for (const char* task : {"3", "take1/wide", "0", "2"}) {
    const ProgramOutcome outcome =
        study.Run(single, std::string("--task=") + task);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  }
  EXPECT_FALSE(fs::exists(single + "/batch.md"));
  // The results know what they are of.
  ASSERT_EQ(RunProgram("batch", "--merge --out=" + single).exit_code, 0);
  const ProgramOutcome difference =
      RunShell("diff -r '" + all + "' '" + single + "'");
  EXPECT_EQ(difference.exit_code, 0) << difference.output;
}

TEST(BatchTest, NeverMixesResultsOfOtherSettings) {
  const Study study(false);
  const std::string out = study.Out("out");
  ASSERT_EQ(study.Run(out, "").exit_code, 0);
  std::string text = ContentOf(study.manifest);
  text.replace(text.find("alpha_epi=40"), 12, "alpha_epi=41");
  std::ofstream(study.manifest) << text;
  const ProgramOutcome outcome = study.Run(out, "--resume");
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.errors, HasSubstr("take1/wide: was made from other"));
  EXPECT_TRUE(fs::exists(out + "/take1/wide/tracks.jsonl"));
}

TEST(BatchTest, AKilledBatchGoesOn) {
  const Study study(false);
  const std::string whole = study.Out("whole");
  ASSERT_EQ(study.Run(whole, "").exit_code, 0);
  const std::string out = study.Out("killed");
  {
    RunningProgram program(
        {ProgramPath("batch"), "--manifest=" + study.manifest, "--out=" + out,
         "--jobs=1"},
        study.Out("errors"));
    ASSERT_TRUE(
        WaitUntil([&] { return fs::exists(out + "/take1/plain/task.json"); }));
    program.Signal(SIGTERM);
    const int status = program.Wait();
    EXPECT_TRUE(WIFSIGNALED(status) || WEXITSTATUS(status) == 0);
  }
  EXPECT_FALSE(HasPartial(out + "/take1"));
  ASSERT_EQ(study.Run(out, "--resume").exit_code, 0);
  const ProgramOutcome difference =
      RunShell("diff -r '" + whole + "' '" + out + "'");
  EXPECT_EQ(difference.exit_code, 0) << difference.output;
}

TEST(BatchTest, RefusesManifestsWithMistakes) {
  const TemporaryFolder folder;
  const auto error_of = [&](const std::string& text) {
    const ProgramOutcome outcome =
        RunProgram("batch", "--manifest=" + folder.Write("m.toml", text) +
                                " --out=" + (folder.path() / "out").string());
    EXPECT_EQ(outcome.exit_code, 2) << text;
    return outcome.errors;
  };
  EXPECT_THAT(error_of(""), HasSubstr("[[takes]]: there is none"));
  EXPECT_THAT(error_of("takes = 3"), HasSubstr("expected an array"));
  EXPECT_THAT(error_of("colour = 3"), HasSubstr("'colour'"));
  const std::string recording =
      "[[takes]]\nname = \"a\"\ncameras = \"c\"\ndetections = \"d\"\n";
  EXPECT_THAT(error_of(recording),
              HasSubstr("[[configurations]]: there is none"));
  EXPECT_THAT(error_of(recording + recording), HasSubstr("'a' is given twice"));
  EXPECT_THAT(error_of(recording + "protocol = \"mpjpe\"\n"),
              HasSubstr("belong together"));
  EXPECT_THAT(error_of("[[takes]]\nname = \"../a\"\ncameras = \"c\"\n"
                       "detections = \"d\"\n"),
              HasSubstr("cannot be the name of a file"));
  EXPECT_FALSE(fs::exists(folder.path() / "out"));
}

TEST(BatchSummaryTest, DrawsRecordings) {
  // Two recordings without errors of their own: the mean of two draws is 0, 1
  // or 2 with probabilities 1/4, 1/2 and 1/4, so the interval of 95 % is all of
  // it.
  const BatchColumn column = {BatchValue{0.0, 0.0}, std::nullopt,
                              BatchValue{2.0, 0.0}};
  const BatchSummary summary = Summarise(column);
  EXPECT_EQ(summary.recordings, 2);
  EXPECT_DOUBLE_EQ(summary.mean, 1.0);
  EXPECT_DOUBLE_EQ(summary.interval.low, 0.0);
  EXPECT_DOUBLE_EQ(summary.interval.high, 2.0);
}

TEST(BatchSummaryTest, DrawsWithinARecording) {
  // One recording: its own standard error alone. 2000 draws place the 2.5 %
  // points of a normal distribution with a standard error of 0.06 sigma (order
  // statistics: sqrt(p (1 - p) / n) over the density there); four of them.
  const BatchSummary summary = Summarise({BatchValue{10.0, 3.0}});
  EXPECT_NEAR(summary.interval.low, 10.0 - 1.96 * 3.0, 4 * 0.06 * 3.0);
  EXPECT_NEAR(summary.interval.high, 10.0 + 1.96 * 3.0, 4 * 0.06 * 3.0);
}

TEST(BatchSummaryTest, TakesDifferencesTakeByTake) {
  // A constant difference is certain, however much the recordings differ.
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
