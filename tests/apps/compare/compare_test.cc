// The whole comparison on synthetic recordings, whose truth is known.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "apps/common/app.h"
#include "apps/common/config_folder.h"
#include "apps/common/synthesis.h"
#include "apps/compare/comparison.h"
#include "apps/compare/output.h"
#include "apps/compare/scores.h"
#include "apps/compare/strategies.h"
#include "apps/compare/tuning.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/io/configuration/config.h"
#include "tests/apps/command.h"
#include "tests/core/io/input_error.h"

namespace kinegraph {
namespace {

using testing::ContentOf;
using testing::Done;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::MatchesRegex;
using ::testing::Not;
using testing::Refusal;

// Two people, five cameras, six seconds at 25 Hz; white noise.
SyntheticRecording MakeNoisyRecording(const std::string& sigma_px = "6") {
  return MakeRecording(
      ProjectConfig("synthetic/correlated_25hz.toml"),
      "scene.people=2;scene.duration=6;noise.correlation_time=0;"
      "noise.sigma=" +
          sigma_px);
}

RunOptions Options() {
  return ReadRunOptions(ProjectConfig("synthetic/track_paper.toml"), "", "");
}

FrozenRun Freeze(const SyntheticRecording& recording,
                 const DetectionSequence& detections) {
  RunRequest request;
  request.cameras = recording.scene.cameras;
  return FreezeTracking(Options(), request, detections);
}

// The strategies `names`, unscored, with one fold per range of frames.
CompareResult Compare(const SyntheticRecording& recording,
                      const std::string& names, int threads = 1,
                      const std::vector<FrameRange>& ranges = {{0, 1000}}) {
  FrozenRun run = Freeze(recording, recording.detections);
  const auto prepared =
      PrepareRecording(run, Options(), run.detections, threads);
  std::vector<Fold> folds;
  for (const FrameRange& range : ranges) folds.push_back({range, prepared});
  CompareResult result;
  result.comparison = MakeComparison("c.json", Options(), std::move(run),
                                     std::move(folds), std::nullopt, threads);
  result.comparison.truth = recording.truth;
  for (const Strategy& strategy :
       ChooseStrategies(ParseList(names, "strategies"))) {
    StrategyResult& one = result.strategies.emplace_back();
    one.strategy = strategy;
    one.values.assign(
        ranges.size(),
        DefaultValues(strategy, 25.0, result.comparison.options.estimators));
  }
  return result;
}

std::vector<Strategy> StrategiesOf(const CompareResult& result) {
  std::vector<Strategy> strategies;
  for (const StrategyResult& one : result.strategies) {
    strategies.push_back(one.strategy);
  }
  return strategies;
}

Verdict HeldOutVerdict(const CompareResult& result, size_t index) {
  return result.strategies[index].Find("held_out_mean_px")->verdict;
}

TEST(Compare, RanksABetterAndAWorseStrategy) {
  CompareResult result =
      Compare(MakeNoisyRecording(), "raw_dlt,batch,centred_gaussian");
  // Smooths over seconds, far too long for gait.
  result.strategies[2].values = {{1.5}};
  Score(&result);
  EXPECT_EQ(HeldOutVerdict(result, 0), Verdict::kNone);
  EXPECT_EQ(HeldOutVerdict(result, 1), Verdict::kLess);
  EXPECT_EQ(HeldOutVerdict(result, 2), Verdict::kMore);
  // The truth agrees.
  EXPECT_EQ(result.strategies[1].Find("mpjpe_mm")->verdict, Verdict::kLess);
  EXPECT_EQ(result.strategies[2].Find("mpjpe_mm")->verdict, Verdict::kMore);
  // Batch and Gaussian are smoother, but only the batch is more accurate.
  for (const size_t index : {1u, 2u}) {
    for (const char* key :
         {"acceleration_m_s2", "jerk_m_s3", "power_above_6hz_mm2"}) {
      EXPECT_EQ(result.strategies[index].Find(key)->verdict, Verdict::kLess)
          << key;
    }
  }
  const std::string text = RankingText(result);
  EXPECT_THAT(text, HasSubstr("- better: batch.\n"));
  EXPECT_THAT(text, HasSubstr("- not significant: none.\n"));
  EXPECT_THAT(text, HasSubstr("- worse: centred Gaussian.\n"));
}

TEST(Compare, AnInsignificantDifferenceIsNotBetter) {
  CompareResult result = Compare(MakeNoisyRecording(), "raw_dlt,batch");
  Score(&result);
  StrategyResult& other = result.strategies[1];
  // Ten frames worse by 1 px, ten frames better, in turn: nearly equal on
  // average.
  other.scores = result.strategies[0].scores;
  RatioSeries& errors = other.scores.held_out_errors;
  for (size_t k = 0; k < errors.size(); ++k) {
    const bool up = (k / 10) % 2 == 0;
    errors[k].sum += errors[k].weight * ((up ? 1.0 : -1.0) - 0.001);
  }
  for (StrategyResult& one : result.strategies) one.measures.clear();
  AddMeasures(&result);
  EXPECT_EQ(HeldOutVerdict(result, 1), Verdict::kSame);
  EXPECT_THAT(RankingText(result), HasSubstr("- better: none.\n"));
  EXPECT_THAT(RankingText(result), HasSubstr("- not significant: batch.\n"));
}

TEST(Compare, NoSmoothingEqualsTheBaseline) {
  CompareResult result =
      Compare(MakeNoisyRecording(), "raw_dlt,centred_gaussian");
  // Four sigmas of 1 ms reach no neighbouring frame.
  result.strategies[1].values = {{0.001}};
  Score(&result);
  for (const char* key : {"held_out_mean_px", "mpjpe_mm"}) {
    EXPECT_NEAR(result.strategies[1].Find(key)->difference, 0.0, 1e-9) << key;
  }
}

TEST(Compare, MeasuresALagOfACausalFilterAndNoneOfTheBatch) {
  CompareResult result =
      Compare(MakeNoisyRecording("0.5"), "batch,kalman_cv,one_euro");
  // A hundredth of the filter's process noise, so that q is 0.005 (hips) to
  // 0.05 m^2/s^3 (ankles). The filter assumes detections of 6 px at 4 m, points
  // of about R = (15 mm)^2 every h = 0.04 s, so that its crossover w_c = (q /
  // (R h))^(1/4) lies at 5 (hips) to 9 rad/s (ankles). Its gain (g s + w_c^2) /
  // (s^2 + g s + w_c^2), g = sqrt(2) w_c, delays gait's 2 pi rad/s by 50 ms or
  // more.
  result.strategies[1].values = {{0.01}};
  result.strategies[2].values = {{0.5, 0.0}};  // a slow low-pass: 0.3 s
  Score(&result);
  const auto lag_ms = [&](size_t index) {
    return result.strategies[index].Find("lag_to_truth_ms")->value;
  };
  EXPECT_NEAR(lag_ms(0), 0.0, 5.0);  // an eighth of a frame
  EXPECT_GT(lag_ms(1), 20.0);        // half a frame
  EXPECT_GT(lag_ms(2), 60.0);
  EXPECT_TRUE(result.strategies[0].scores.run.whole_recording);
}

TEST(Compare, RefusesStrategiesThatDoNotFitTheRecording) {
  CompareResult result = Compare(MakeNoisyRecording(), "raw_dlt,butterworth");
  result.strategies[1].values = {{20.0}};  // above half of 25 Hz
  Score(&result);
  EXPECT_FALSE(result.strategies[1].scores.refused.empty());
  EXPECT_THAT(CompareMarkdown(result, {}), HasSubstr("cannot be run here"));
}

// The batch, to which lags are relative, refuses these options.
TEST(Compare, FiltersAreScoredWithoutTheBatch) {
  CompareResult result =
      Compare(MakeNoisyRecording(), "raw_dlt,butterworth,batch");
  result.comparison.options.estimators.graph.stages.clear();
  Score(&result);
  EXPECT_FALSE(result.strategies[2].ran());
  const StrategyResult& filter = result.strategies[1];
  EXPECT_GT(filter.Find("held_out_mean_px")->value, 0.0);
  EXPECT_TRUE(std::isnan(filter.Find("lag_to_batch_ms")->value));
  EXPECT_FALSE(std::isnan(filter.Find("lag_to_truth_ms")->value));
}

// ---- Tuning

const std::vector<FrameRange> kFolds = {{0, 62}, {87, 150}};

TEST(Tuning, ChoosesOnOneFoldAndScoresOnTheOther) {
  CompareResult result =
      Compare(MakeNoisyRecording(), "raw_dlt,centred_gaussian", 2, kFolds);
  const std::vector<Strategy> strategies = StrategiesOf(result);
  const StrategyTuning tuning =
      TuneStrategies(result.comparison, strategies)[1];
  ASSERT_EQ(tuning.points.size(), strategies[1].parameters.front().grid.size());
  for (size_t fold = 0; fold < 2; ++fold) {
    // The values chosen for this fold have the least error in the frames of the
    // other fold.
    const TuningPoint* best = &tuning.points.front();
    for (const TuningPoint& point : tuning.points) {
      if (point.error_px[1 - fold] < best->error_px[1 - fold]) best = &point;
    }
    EXPECT_EQ(tuning.chosen[fold], best->values);
    result.strategies[1].values[fold] = best->values;
  }
  EXPECT_LE(tuning.same_fold_px, tuning.cross_px);
  // Slow people and 6 px of noise: the optimum is inside the grid.
  EXPECT_GT(tuning.chosen[0][0], strategies[1].parameters[0].grid.front());
  EXPECT_LT(tuning.chosen[0][0], strategies[1].parameters[0].grid.back());
  // Subsequent scores equal those of tuning.
  Score(&result);
  EXPECT_NEAR(result.strategies[1].Find("held_out_mean_px")->value,
              tuning.cross_px, 1e-9);
}

TEST(Tuning, WindowsUseTheTunedValuesOfTheBatch) {
  const auto tuned = [](const std::vector<std::string>& names) {
    std::vector<std::string> themselves;
    for (const Strategy& one : TunedThemselves(ChooseStrategies(names))) {
      themselves.push_back(one.name);
    }
    return themselves;
  };
  EXPECT_THAT(tuned({"window_0", "window_10"}), ElementsAre("batch"));
  EXPECT_THAT(tuned({"window_0", "batch", "rts_cv"}),
              ElementsAre("batch", "rts_cv"));
}

TEST(Tuning, ParametersReadBackToTheSameBits) {
  const testing::TemporaryFolder folder;
  const std::string path = (folder.path() / "parameters.toml").string();
  const std::vector<Strategy> strategies =
      ChooseStrategies({"one_euro", "raw_dlt", "butterworth"});
  ParameterFile written;
  written.folds = kFolds;
  written.strategies = {
      {{1.0 / 3.0, 2.0}, {0.5, 3.0}}, {{}, {}}, {{4.0}, {6.0}}};
  WriteParameters(strategies, written, path);
  const ParameterFile read =
      ReadParameters(path, strategies, 25.0, EstimatorOptions());
  EXPECT_EQ(read.strategies, written.strategies);
  ASSERT_EQ(read.folds.size(), 2u);
  EXPECT_EQ(read.folds[1].begin, 87);
  EXPECT_EQ(read.folds[1].end, 150);
}

TEST(Tuning, SuggestsAKeyForAnUnknownKeyInTheFile) {
  const testing::TemporaryFolder folder;
  const std::string path =
      folder.Write("parameters.toml", "[first.butterworth]\ncutof_hz = 3\n");
  EXPECT_THAT(testing::InputErrorOf([&] {
                ReadParameters(path, ChooseStrategies({"butterworth"}), 25.0,
                               EstimatorOptions());
              }),
              HasSubstr("did you mean"));
}

TEST(Tuning, StrategiesByRulesTakeNoParametersFromTheFile) {
  const testing::TemporaryFolder folder;
  const std::string path =
      folder.Write("parameters.toml", "[first.butterworth]\ncutoff_hz = 3\n");
  const ParameterFile read =
      ReadParameters(path, ChooseStrategies({"butterworth_yu", "butterworth"}),
                     25.0, EstimatorOptions());
  const std::vector<FoldValues> expected = {{{}}, {{3.0}}};
  EXPECT_EQ(read.strategies, expected);
}

// ---- Shifts

TEST(Shift, ImageShiftOfACameraIsEstimatedAndRemoved) {
  const SyntheticRecording recording = MakeNoisyRecording("3");
  DetectionSequence moved = recording.detections;
  const Eigen::Vector2d off(14.0, -9.0);
  for (DetectionFrame& frame : moved.frames) {
    for (Detection& detection : frame.views[1].detections) {
      for (Keypoint& joint : detection.joints) joint.px += off;
    }
  }
  const FrozenRun run = Freeze(recording, moved);
  const std::vector<Eigen::Vector2d> shifts =
      FitShifts(run, Options(), {0, 62}, 1);
  ASSERT_EQ(shifts.size(), 5u);
  // Moving the world explains part of one camera's shift, but less than half.
  EXPECT_GT(shifts[1].dot(off), 0.5 * off.squaredNorm());
  const auto error = [&](const DetectionSequence& detections) {
    std::vector<Fold> folds = {
        {{87, 150}, PrepareRecording(run, Options(), detections, 1)}};
    const Comparison comparison = MakeComparison(
        "c.json", Options(), run, std::move(folds), std::nullopt, 1);
    HeldOutScores scores;
    for (size_t view = 0; view < 5; ++view) {
      ScoreWithout(comparison, comparison.folds[0], view,
                   RunWithout(comparison, ChooseStrategies({"raw_dlt"}).front(),
                              {}, *comparison.folds[0].recording, view),
                   &scores);
    }
    return PooledRatio({TruncatedErrors(scores, AllJoints())});
  };
  const double before = error(run.detections);
  const double after = error(Shifted(run.detections, shifts));
  const double without_any = error(recording.detections);
  EXPECT_GT(before, 1.5 * without_any);
  EXPECT_LT(after, 1.05 * without_any);
}

TEST(Scores, CommonScoresUseOnlyJointsThatAllPredict) {
  StrategyScores one, other;
  one.joint_errors_px = {1.0F, 2.0F, -1.0F, 40.0F};  // negative: not predicted
  other.joint_errors_px = {3.0F, -1.0F, 5.0F, 6.0F};
  for (StrategyScores* scores : {&one, &other}) {
    scores->joint_units = {0, 0, 1, 1};
    scores->held_out_errors.resize(2);
  }
  AddCommon({&one, &other});
  // The first joint and the last.
  EXPECT_DOUBLE_EQ(one.held_out_common_median_px, 20.5);
  EXPECT_DOUBLE_EQ(other.held_out_common_median_px, 4.5);
  EXPECT_DOUBLE_EQ(one.held_out_common[1].sum, 30.0);  // the cap of the mean
  EXPECT_DOUBLE_EQ(other.held_out_common[0].weight, 1.0);
}

TEST(Scores, ErrorsCsvAveragesToTheMeanError) {
  CompareResult result = Compare(MakeNoisyRecording(), "raw_dlt,batch");
  Score(&result);
  std::istringstream lines(ErrorsCsv(result));
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line, "frame,raw_dlt,batch");
  double sums_px[] = {0.0, 0.0};
  int count = 0;
  while (std::getline(lines, line)) {
    const std::vector<std::string> cells = Split(line, ',');
    ASSERT_EQ(cells.size(), 3u) << line;
    const int frame = std::stoi(cells[0]);
    EXPECT_GE(frame, 0);
    EXPECT_LT(frame, 150);
    for (size_t i = 0; i < 2; ++i) {
      const std::string& error_px = cells[i + 1];
      sums_px[i] +=
          error_px.empty() ? 30.0 : std::min(30.0, std::stod(error_px));
    }
    ++count;
  }
  ASSERT_GT(count, 1000);
  for (size_t i = 0; i < 2; ++i) {
    // Errors are stored as floats (relative precision 6e-8), up to 30 px.
    EXPECT_NEAR(sums_px[i] / count,
                result.strategies[i].Find("held_out_mean_px")->value, 2e-6);
  }
}

// Compares estimates without the truth with figures from the truth. The
// tolerance is half of the figure: errors in held-out cameras are perpendicular
// to the rays, errors against the truth have three directions, and one camera
// is missing.
TEST(Scores, EstimatesRemovedMotionWithoutTruth) {
  SyntheticRecording recording = MakeNoisyRecording();
  CompareResult result = Compare(recording, "raw_dlt,butterworth,batch");
  result.comparison.options.estimators.filters.butterworth.choice =
      CutoffChoice::kFixed;
  result.comparison.options.estimators.filters.butterworth.cutoff_hz = 0.4;
  result.strategies[1].values.assign(
      1, DefaultValues(result.strategies[1].strategy, 25.0,
                       result.comparison.options.estimators));
  Score(&result);
  const auto of = [&](size_t strategy, const char* key) {
    return result.strategies[strategy].Find(key)->value;
  };
  EXPECT_NEAR(of(1, "motion_removed_mm"), of(1, "truth_motion_removed_mm"),
              0.5 * of(1, "truth_motion_removed_mm"));
  EXPECT_GT(of(1, "motion_removed_mm"), 3.0 * of(2, "motion_removed_mm"));
  EXPECT_GT(of(0, "noise_kept_mm"), 2.0 * of(2, "noise_kept_mm"));
  const std::vector<std::string> sentences = BalanceSentences(result);
  ASSERT_EQ(sentences.size(), 2u);
  EXPECT_THAT(sentences[0], MatchesRegex("warning: motion is removed or "
                                         "delayed by Butterworth[^;]*joints."
                                         "*"));
  EXPECT_THAT(sentences[1], HasSubstr("noise is kept by raw DLT"));
}

// ---- The table

TEST(Strategies, HaveUniqueNamesAndSettableParameters) {
  const std::vector<Strategy>& all = AllStrategies();
  for (size_t s = 0; s < all.size(); ++s) {
    for (size_t other = 0; other < s; ++other) {
      EXPECT_NE(all[s].name, all[other].name);
      EXPECT_NE(all[s].title, all[other].title);
    }
    EXPECT_LE(all[s].parameters.size(), 2u);
    for (const SmootherParameter& parameter : all[s].parameters) {
      EXPECT_TRUE(std::is_sorted(parameter.grid.begin(), parameter.grid.end()));
      EstimatorOptions before, after;
      parameter.set(parameter.grid.front(), &before);
      parameter.set(parameter.grid.back(), &after);
      EXPECT_NE(EffectiveConfigJson(before), EffectiveConfigJson(after))
          << all[s].name << ", " << parameter.name;
    }
  }
  EXPECT_THROW(ChooseStrategies({"butterwort"}), InputError);
  EXPECT_THROW(ChooseStrategies({"batch", "batch"}), InputError);
}

TEST(Strategies, GridHasAllCombinations) {
  const Strategy one_euro = ChooseStrategies({"one_euro"}).front();
  const std::vector<StrategyValues> grid = GridOf(one_euro);
  EXPECT_EQ(grid.size(), one_euro.parameters[0].grid.size() *
                             one_euro.parameters[1].grid.size());
  EXPECT_EQ(grid[1][0], one_euro.parameters[0].grid[0]);
  EXPECT_EQ(grid[1][1], one_euro.parameters[1].grid[1]);
}

TEST(Strategies, RecommendationKeepsSkeletonsOfTheConfiguration) {
  const RunOptions options = ParseRunOptions(
      "mode = \"graph\"\n[detections]\nskeleton = \"my body\"\n"
      "[skeletons.\"my body\"]\njoints = [\"tail\", \"head\", \"paw\"]\n"
      "bones = [[\"tail\", \"head\"], [\"head\", \"paw\"]]\n",
      "", "");
  const RunOptions read = ParseRunOptions(ChangedKeysToml(options), "", "");
  EXPECT_EQ(read.user_skeletons, options.user_skeletons);
  EXPECT_EQ(read.user_skeletons.size(), 1u);
}

// ---- The command

class CompareCommand : public testing::CommandTest {
 protected:
  CompareCommand() { WriteRecording(MakeNoisyRecording(), Path("take")); }
  std::string Flags(const std::string& out, const std::string& more) const {
    return "--cameras='" + Path("take/cameras.json") + "' --detections='" +
           Path("take/detections.jsonl") + "' --ground_truth='" +
           Path("take/truth.jsonl") + "' --protocol=mpjpe --config='" +
           ProjectConfig("synthetic/track_paper.toml") + "' --out='" +
           Path(out) + "' " + more;
  }
};

TEST_F(CompareCommand, WritesTheSameFilesForAnyNumberOfThreads) {
  const std::string strategies =
      "--strategies=raw_dlt,butterworth,rts_cv --noplots ";
  for (const std::string threads : {"1", "3"}) {
    const auto outcome = Done(
        "compare",
        Flags(threads,
              strategies + "--tune --errors --angles --threads=" + threads));
    // On a slow machine a progress line may be printed after half a minute.
    EXPECT_THAT(outcome.errors,
                MatchesRegex("((tuning|scoring) +[0-9][^\n]*\n)*"));
    EXPECT_THAT(outcome.output, HasSubstr("ean held-out error"));
    EXPECT_THAT(outcome.output, HasSubstr("Best: "));
    std::istringstream lines(outcome.output);
    for (std::string line; std::getline(lines, line);) {
      EXPECT_LE(line.size(), 100u) << line;
    }
    EXPECT_TRUE(std::filesystem::exists(Path(threads + "/runtime.json")));
  }
  for (const std::string name :
       {"/compare.json", "/compare.csv", "/compare.md", "/errors.csv",
        "/cutoffs.csv", "/derivatives.csv", "/parameters.toml",
        "/recommended.toml"}) {
    const std::string one = ContentOf(Path("1" + name));
    EXPECT_FALSE(one.empty()) << name;
    EXPECT_EQ(one, ContentOf(Path("3" + name))) << name;
  }
  // The recommendation is a configuration of one of the three strategies.
  const RunOptions recommended =
      ReadRunOptions(Path("1/recommended.toml"), "", "");
  EXPECT_EQ(recommended.estimators.mode, Mode::kGraph);
  const OutputKind kind = recommended.estimators.output;
  EXPECT_TRUE(kind == OutputKind::kRawDlt || kind == OutputKind::kButterworth ||
              kind == OutputKind::kRts);
  EXPECT_THAT(ContentOf(Path("1/compare.md")), HasSubstr("Best: "));
  // Tuned parameters can be scored again without tuning.
  Done("compare", Flags("again", strategies + "--angles --parameters='" +
                                     Path("1/parameters.toml") + "'"));
  EXPECT_EQ(ContentOf(Path("1/compare.csv")),
            ContentOf(Path("again/compare.csv")));
}

// Rows of a CSV that has no quotes, by the header's names.
std::vector<std::map<std::string, std::string>> RowsOfCsv(
    const std::string& text) {
  std::vector<std::vector<std::string>> cells;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    cells.push_back(Split(line, ','));
  }
  std::vector<std::map<std::string, std::string>> rows;
  for (size_t i = 1; i < cells.size(); ++i) {
    rows.emplace_back();
    for (size_t c = 0; c < cells[i].size(); ++c) {
      rows.back()[cells[0].at(c)] = cells[i][c];
    }
  }
  return rows;
}

TEST_F(CompareCommand, WritesCutoffsOfEveryRuleAndErrorsOfDerivatives) {
  Done("compare",
       Flags("out", "--strategies=raw_dlt,butterworth_yu,rts_cv --noplots"));
  // Every rule has cut-offs for three axes and for all axes together, for most
  // joints of both people.
  const auto cutoffs = RowsOfCsv(ContentOf(Path("out/cutoffs.csv")));
  EXPECT_EQ(cutoffs.size() % (7 * 4), 0u);
  EXPECT_GE(cutoffs.size(), 7u * 4u * 20u);
  for (const auto& row : cutoffs) {
    EXPECT_GE(std::stod(row.at("cutoff_hz")), 0.25) << row.at("rule");
    EXPECT_LE(std::stod(row.at("cutoff_hz")), 0.45 * 25.0) << row.at("rule");
  }
  std::map<std::string, std::map<std::string, double>> derivatives;
  for (const auto& row : RowsOfCsv(ContentOf(Path("out/derivatives.csv")))) {
    if (row.at("joint") != "all" || row.at("frames") != "all") continue;
    auto& mine = derivatives[row.at("strategy")];
    mine["v"] = std::stod(row.at("velocity_rms_m_s"));
    mine["a"] = std::stod(row.at("acceleration_rms_m_s2"));
  }
  // Differences of raw points are worse than any smoother's.
  for (const std::string name : {"butterworth_yu", "rts_cv"}) {
    EXPECT_LT(derivatives[name]["v"], derivatives["raw_dlt"]["v"]) << name;
    EXPECT_LT(derivatives[name]["a"], 0.5 * derivatives["raw_dlt"]["a"])
        << name;
  }
  const std::string markdown = ContentOf(Path("out/compare.md"));
  EXPECT_THAT(markdown, HasSubstr("## Cut-offs that rules choose"));
  EXPECT_THAT(markdown, HasSubstr("central differences"));
  EXPECT_THAT(markdown, Not(HasSubstr("Joint angles")));
}

TEST_F(CompareCommand, ErrorOfAMissingImageSizeNamesTheCalibration) {
  std::string text = ContentOf(Path("take/cameras.json"));
  const std::string size = "\"image_size\":[";
  for (size_t at = text.find(size); at != std::string::npos;
       at = text.find(size)) {
    text.replace(at, text.find(']', at) + 1 - at, "\"image_size\":null");
  }
  folder_.Write("take/sizeless.json", text);
  const std::string flags = Flags("out", "--noplots --strategies=raw_dlt");
  EXPECT_THAT(
      Refusal("compare", std::string(flags).replace(flags.find("cameras.json"),
                                                    12, "sizeless.json")),
      HasSubstr(Path("take/sizeless.json") + ": camera 'cam0': no image size"));
}

TEST_F(CompareCommand, DrawsPlots) {
  if (std::system("command -v gnuplot > /dev/null") != 0) {
    GTEST_SKIP() << "gnuplot is not installed";
  }
  Done("compare", Flags("out", "--strategies=raw_dlt,window_0,window_3,batch"));
  for (const std::string name :
       {"held_out_smoothness.svg", "held_out_difference.svg",
        "error_by_joint_class.svg", "trajectory.svg", "lag_sweep.svg",
        "cutoffs.svg"}) {
    EXPECT_THAT(ContentOf(Path("out/" + name)), HasSubstr("</svg>")) << name;
  }
}

TEST_F(CompareCommand, InvalidFlagsAreRefusedWithTheCause) {
  const std::pair<const char*, const char*> cases[] = {
      {"--strategies=kalmann", "no strategy is named"},
      {"--baseline=nobody", "no strategy is named"},
      {"--tune --parameters=x.toml", "exclude each other"},
      {"--folds=0:9 --tune", "expected two"},
      {"--folds=0:100,900:1000 --tune",
       "900:1000 has no detection of a tracked person"},
      {"--folds=0:100,900:1000 --fit_shift",
       "900:1000 has no detection of a tracked person"},
      {"--threads=0", "at least 1"},
      {"--joint=r_wirst", "--joint: found 'r_wirst', expected one of "},
      {"--strategies=raw_dlt --plot_strategies=raw_dlt,batch",
       "--plot_strategies: found 'batch', expected a strategy that is "
       "compared"},
      {"--markers=x.c3d", "exclude each other"}};
  for (const auto& [flags, cause] : cases) {
    EXPECT_THAT(Refusal("compare", Flags("out", "--noplots ") + flags),
                HasSubstr(cause));
  }
  // The folder of the recording is not empty.
  EXPECT_THAT(Refusal("compare", Flags("take", "--noplots")),
              HasSubstr("take"));
  EXPECT_FALSE(std::filesystem::exists(Path("out")));
}

}  // namespace
}  // namespace kinegraph
