// Several recordings: each is scored with values chosen on the others.
#include "apps/compare/study.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "core/io/configuration/config.h"
#include "core/io/text/json.h"
#include "tests/apps/command.h"

namespace kinegraph {
namespace {

using testing::ContentOf;
using testing::Done;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::ProjectFile;
using testing::Refusal;
using testing::TemporaryFolder;

TEST(BestPoint, MinimisesTheMeanOfRecordingMeans) {
  // Point 1 is best by the mean of means (3), though point 0 has a smaller
  // error in the long first recording.
  const std::vector<PointErrors> recordings = {{{200.0, 100.0}, {300.0, 100.0}},
                                               {{60.0, 10.0}, {30.0, 10.0}}};
  EXPECT_EQ(BestPoint(recordings, -1), 1u);
  // The recording left out has no influence.
  EXPECT_EQ(BestPoint(recordings, 1), 0u);
  EXPECT_EQ(BestPoint(recordings, 0), 1u);
  // Of equal points the first is chosen.
  EXPECT_EQ(BestPoint({{{2.0, 1.0}, {2.0, 1.0}}}, -1), 0u);
}

TEST(BestPoint, SkipsPointsThatARecordingRefuses) {
  const RatioUnit refused;
  const std::vector<PointErrors> recordings = {{{1.0, 1.0}, {9.0, 1.0}},
                                               {refused, {9.0, 1.0}}};
  EXPECT_EQ(BestPoint(recordings, -1), 1u);
  EXPECT_EQ(BestPoint(recordings, 1), 0u);
  EXPECT_EQ(BestPoint({{refused}}, -1), std::nullopt);
  EXPECT_EQ(BestPoint({{{1.0, 1.0}}}, 0), std::nullopt);  // none is left
}

StudyRecording RecordingWith(size_t chosen, Verdict verdict) {
  StudyRecording recording;
  recording.name = "t";
  recording.scores.resize(3);
  recording.scores[chosen].verdict = verdict;
  recording.chosen = chosen;
  return recording;
}

TEST(Study, CountsRecordingsByVerdict) {
  Study study;
  study.best = 1;
  study.recordings = {
      RecordingWith(1, Verdict::kLess), RecordingWith(1, Verdict::kSame),
      RecordingWith(2, Verdict::kMore), RecordingWith(0, Verdict::kNone)};
  study.recordings.emplace_back().scores.resize(3);  // nothing could be chosen
  const StudyVerdict verdict = HoldsFor(study);
  EXPECT_EQ(verdict.recordings, 4);
  EXPECT_EQ(verdict.better, 1);
  EXPECT_EQ(verdict.same, 2);  // the baseline equals itself
  EXPECT_EQ(verdict.worse, 1);
  EXPECT_EQ(verdict.like_all, 2);
}

// Three recordings of three seconds.
class StudyCommand : public testing::CommandTest {
 protected:
  StudyCommand() {
    std::string text;
    for (const std::string seed : {"1", "2", "3"}) {
      const std::string name = "take" + seed;
      Done("synthesize",
           "--config=" +
               ProjectFile("configs/synthetic/correlated_25hz.toml").string() +
               " --set='scene.people=1;scene.duration=3;scene.seed=" + seed +
               ";noise.seed=" + seed + "' --out=" + Path(name));
      text += "[[takes]]\nname = \"" + name + "\"\ncameras = \"" + name +
              "/cameras.json\"\ndetections = \"" + name +
              "/detections.jsonl\"\n";
      if (seed == "1") text += "set = \"cameras.unit=m\"\n";
    }
    takes_ = folder_.Write("only_takes.toml", text);
    manifest_ = folder_.Write("takes.toml", text +
                                                "[[configurations]]\nname = "
                                                "\"paper\"\nconfig = \"" +
                                                config_ + "\"\n");
  }

  const std::string config_ =
      ProjectFile("configs/synthetic/track_paper.toml").string();
  std::string manifest_;
  std::string takes_;  // the same without a configuration
};

TEST_F(StudyCommand, ScoresTunedValuesOnTheRecordingLeftOut) {
  const std::string out = Path("study");
  EXPECT_THAT(
      Done("compare",
           "--manifest=" + manifest_ +
               " --tune --strategies=causal_gaussian,butterworth --out=" + out)
          .output,
      HasSubstr("Leave-one-out"));
  const Json study = Json::parse(ContentOf(out + "/study.json"));
  EXPECT_EQ(study["takes"].size(), 3u);
  EXPECT_EQ(study["holds"]["takes"], 3);
  EXPECT_EQ(study["strategies"]["butterworth"]["difference_px"]["takes"], 3);
  for (const auto& [name, recording] : study["takes"].items()) {
    // One value was tuned: the cut-off.
    const Json& score = recording["strategies"]["butterworth"];
    EXPECT_EQ(score["values"].size(), 1u) << name;
    EXPECT_GT(score["held_out_mean_px"], 0.0);
  }
  // The recommendation is a complete configuration that states on how many
  // recordings it was chosen.
  const std::string toml = ContentOf(out + "/recommended.toml");
  EXPECT_THAT(toml, HasSubstr("best over 3 recordings"));
  EXPECT_THAT(toml, HasSubstr("of 3 recordings"));
  EXPECT_EQ(ReadRunOptions(out + "/recommended.toml", "", "").estimators.mode,
            Mode::kGraph);
  // Without the keys that the manifest sets for the first recording alone.
  EXPECT_THAT(toml, Not(HasSubstr("unit")));
}

TEST_F(StudyCommand, TheConfigurationCanBeAFlag) {
  const std::string strategies = " --strategies=raw_dlt,butterworth --out=";
  EXPECT_THAT(
      Refusal("compare", "--manifest=" + takes_ + strategies + Path("none")),
      HasSubstr("found 0, expected one (or --config)"));
  Done("compare", "--manifest=" + takes_ + " --config=" + config_ + strategies +
                      Path("flag"));
  Done("compare", "--manifest=" + manifest_ + strategies + Path("table"));
  EXPECT_EQ(ContentOf(Path("flag/study.csv")),
            ContentOf(Path("table/study.csv")));
}

// Without tuning, a recording compared alone has the same scores as in the
// study.
TEST_F(StudyCommand, FiguresMatchRecordingsComparedAlone) {
  const std::string strategies = " --strategies=causal_gaussian,batch --out=";
  Done("compare", "--manifest=" + manifest_ + strategies + Path("study"));
  Done("compare", "--cameras=" + Path("take2/cameras.json") + " --detections=" +
                      Path("take2/detections.jsonl") + " --config=" + config_ +
                      " --noplots" + strategies + Path("alone"));
  const Json study = Json::parse(ContentOf(Path("study/study.json")));
  const Json one = Json::parse(ContentOf(Path("alone/compare.json")));
  ASSERT_EQ(one["strategies"][1]["name"], "batch");
  EXPECT_EQ(study["takes"]["take2"]["strategies"]["batch"]["held_out_mean_px"],
            one["strategies"][1]["measures"]["held_out_mean_px"]["value"]);
}

TEST(Study, ErrorsNameWhatIsMissing) {
  const TemporaryFolder folder;
  const auto refusal = [&](const std::string& takes, const std::string& flags) {
    std::string text;
    for (const char take : takes) {
      text += std::string("[[takes]]\nname = \"") + take +
              "\"\ncameras = \"c\"\ndetections = \"d\"\n";
    }
    text += "[[configurations]]\nname = \"b\"\nconfig = \"" +
            ProjectFile("configs/default.toml").string() + "\"\n";
    return Refusal("compare", "--manifest=" + folder.Write("takes.toml", text) +
                                  flags +
                                  " --out=" + (folder.path() / "out").string());
  };
  EXPECT_THAT(refusal("a", ""), HasSubstr("expected two or more"));
  EXPECT_THAT(refusal("a", " --folds=0:1,2:3"),
              HasSubstr("--folds applies to one recording"));
  EXPECT_THAT(refusal("a", " --joint=nose"),
              HasSubstr("--joint applies to one recording"));
  EXPECT_THAT(refusal("ab", ""), HasSubstr("recording 'a': "));
}

}  // namespace
}  // namespace kinegraph
