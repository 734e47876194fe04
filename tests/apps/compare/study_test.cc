// Several takes: what is chosen on some is scored on the others.
#include "apps/compare/study.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "core/base/error.h"
#include "core/io/configuration/config.h"
#include "core/io/text/json.h"
#include "tests/support/program.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using testing::ContentOf;
using ::testing::HasSubstr;
using testing::ProgramOutcome;
using testing::ProjectFile;
using testing::RunProgram;
using testing::TemporaryFolder;

TEST(BestPoint, IsTheLeastMeanOverTakesOfTheirMeans) {
  // Point 1 is best by the mean of means (3), though the long first recording
  // has less at point 0.
  const std::vector<PointErrors> recordings = {{{200.0, 100.0}, {300.0, 100.0}},
                                               {{60.0, 10.0}, {30.0, 10.0}}};
  EXPECT_EQ(BestPoint(recordings, -1), 1u);
  // The recording that is left out has no say.
  EXPECT_EQ(BestPoint(recordings, 1), 0u);
  EXPECT_EQ(BestPoint(recordings, 0), 1u);
  // The first of equals.
  EXPECT_EQ(BestPoint({{{2.0, 1.0}, {2.0, 1.0}}}, -1), 0u);
}

TEST(BestPoint, LeavesOutWhatATakeRefuses) {
  const RatioUnit refused;
  const std::vector<PointErrors> recordings = {{{1.0, 1.0}, {9.0, 1.0}},
                                               {refused, {9.0, 1.0}}};
  EXPECT_EQ(BestPoint(recordings, -1), 1u);
  EXPECT_EQ(BestPoint(recordings, 1), 0u);
  EXPECT_EQ(BestPoint({{refused}}, -1), std::nullopt);
  EXPECT_EQ(BestPoint({{{1.0, 1.0}}}, 0), std::nullopt);  // nobody is left
}

StudyRecording TakeWith(size_t chosen, Verdict verdict) {
  StudyRecording recording;
  recording.name = "t";
  recording.scores.resize(3);
  recording.scores[chosen].verdict = verdict;
  recording.chosen = chosen;
  return recording;
}

TEST(Study, CountsTheTakesItHoldsFor) {
  Study study;
  study.best = 1;
  study.recordings = {TakeWith(1, Verdict::kLess), TakeWith(1, Verdict::kSame),
                      TakeWith(2, Verdict::kMore), TakeWith(0, Verdict::kNone)};
  study.recordings.emplace_back().scores.resize(3);  // nothing could be chosen
  const StudyVerdict verdict = HoldsFor(study);
  EXPECT_EQ(verdict.recordings, 4);
  EXPECT_EQ(verdict.better, 1);
  EXPECT_EQ(verdict.same, 2);  // the baseline itself is like itself
  EXPECT_EQ(verdict.worse, 1);
  EXPECT_EQ(verdict.like_all, 2);
}

// Three takes of three seconds.
std::string WriteRecordings(const TemporaryFolder& folder) {
  std::string text;
  for (const std::string seed : {"1", "2", "3"}) {
    const std::string name = "take" + seed;
    const ProgramOutcome made = RunProgram(
        "synthesize",
        "--config=" +
            ProjectFile("configs/synthetic/correlated_25hz.toml").string() +
            " --set='scene.people=1;scene.duration=3;scene.seed=" + seed +
            ";noise.seed=" + seed +
            "' --out=" + (folder.path() / name).string());
    EXPECT_EQ(made.exit_code, 0) << made.errors;
    text += "[[takes]]\nname = \"" + name + "\"\ncameras = \"" + name +
            "/cameras.json\"\ndetections = \"" + name + "/detections.jsonl\"\n";
  }
  text += "[[configurations]]\nname = \"paper\"\nconfig = \"" +
          ProjectFile("configs/synthetic/track_paper.toml").string() + "\"\n";
  return folder.Write("takes.toml", text);
}

TEST(Study, ValuesChosenOnSomeTakesAreScoredOnTheOthers) {
  const TemporaryFolder folder;
  const std::string manifest = WriteRecordings(folder);
  const std::string out = (folder.path() / "study").string();
  const ProgramOutcome outcome = RunProgram(
      "compare",
      "--manifest=" + manifest +
          " --tune --strategies=causal_gaussian,butterworth --out=" + out);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_THAT(outcome.output, HasSubstr("Left out in turn"));
  const Json study = Json::parse(ContentOf(out + "/study.json"));
  EXPECT_EQ(study["takes"].size(), 3u);
  EXPECT_EQ(study["holds"]["takes"], 3);
  EXPECT_EQ(study["strategies"]["butterworth"]["difference_px"]["takes"], 3);
  for (const auto& [name, recording] : study["takes"].items()) {
    // The cut-off is one of the grid's, not the configuration's default.
    EXPECT_EQ(recording["strategies"]["butterworth"]["values"].size(), 1u)
        << name;
    EXPECT_GT(recording["strategies"]["butterworth"]["held_out_mean_px"], 0.0);
  }
  // The recommendation is a whole configuration, and says what it holds for.
  const std::string toml = ContentOf(out + "/recommended.toml");
  EXPECT_THAT(toml, HasSubstr("best over 3 recordings"));
  EXPECT_THAT(toml, HasSubstr("of 3 recordings"));
  const RunOptions recommended =
      ReadRunOptions(out + "/recommended.toml", "", "");
  EXPECT_EQ(recommended.estimators.mode, Mode::kGraph);
}

// A recording by itself, with the values the study chose for it, scores the
// same: nothing of the other recordings is left in the figures but the choice.
TEST(Study, FiguresAreThoseOfEachTakeByItself) {
  const TemporaryFolder folder;
  const std::string manifest = WriteRecordings(folder);
  const std::string out = (folder.path() / "study").string();
  ASSERT_EQ(RunProgram("compare",
                       "--manifest=" + manifest +
                           " --strategies=causal_gaussian,batch --out=" + out)
                .exit_code,
            0);
  const std::string alone = (folder.path() / "alone").string();
  const std::string recording = (folder.path() / "take2").string();
  ASSERT_EQ(
      RunProgram(
          "compare",
          "--cameras=" + recording + "/cameras.json --detections=" + recording +
              "/detections.jsonl --config=" +
              ProjectFile("configs/synthetic/track_paper.toml").string() +
              " --noplots --strategies=causal_gaussian,batch --out=" + alone)
          .exit_code,
      0);
  const Json study = Json::parse(ContentOf(out + "/study.json"));
  const Json one = Json::parse(ContentOf(alone + "/compare.json"));
  const double of_study =
      study["takes"]["take2"]["strategies"]["batch"]["held_out_mean_px"];
  double of_one = 0.0;
  for (const Json& strategy : one["strategies"]) {
    if (strategy["name"] != "batch") continue;
    of_one = strategy["measures"]["held_out_mean_px"]["value"];
  }
  EXPECT_EQ(of_study, of_one);
}

TEST(Study, SaysWhatIsMissing) {
  const TemporaryFolder folder;
  const std::string one = folder.Write(
      "one.toml",
      "[[takes]]\nname = \"a\"\ncameras = \"c\"\ndetections = \"d\"\n"
      "[[configurations]]\nname = \"b\"\nconfig = \"e.toml\"\n");
  const std::string out = " --out=" + (folder.path() / "out").string();
  const ProgramOutcome few = RunProgram("compare", "--manifest=" + one + out);
  EXPECT_EQ(few.exit_code, 2);
  EXPECT_THAT(few.errors, HasSubstr("expected two or more"));
  const ProgramOutcome both =
      RunProgram("compare", "--manifest=" + one + " --folds=0:1,2:3" + out);
  EXPECT_EQ(both.exit_code, 2);
  EXPECT_THAT(both.errors, HasSubstr("--folds is of one recording"));
  const std::string manifest = folder.Write(
      "two.toml",
      "[[takes]]\nname = \"a\"\ncameras = \"c\"\ndetections = \"d\"\n"
      "[[takes]]\nname = \"b\"\ncameras = \"c\"\ndetections = \"d\"\n"
      "[[configurations]]\nname = \"b\"\nconfig = \"" +
          ProjectFile("configs/default.toml").string() + "\"\n");
  const ProgramOutcome missing =
      RunProgram("compare", "--manifest=" + manifest + out);
  EXPECT_EQ(missing.exit_code, 2);
  EXPECT_THAT(missing.errors, HasSubstr("take 'a': "));
}

}  // namespace
}  // namespace kinegraph
