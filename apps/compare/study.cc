#include "apps/compare/study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "apps/batch/merge.h"
#include "apps/common/config_folder.h"
#include "apps/common/progress.h"
#include "apps/common/table.h"
#include "apps/compare/output.h"
#include "apps/compare/tuning.h"
#include "core/base/constants.h"
#include "core/base/error.h"
#include "core/io/text/json.h"

namespace kinegraph {
namespace {

// Points of a strategy, and their errors on each recording.
struct StrategyPoints {
  std::vector<StrategyValues> points;
  std::vector<PointErrors> errors;  // [recording]
};

Comparison ComparisonOf(FrozenRecording recording,
                        const StudyRequest& request) {
  const auto prepared =
      PrepareRecording(recording.run, recording.options,
                       recording.run.detections, request.threads);
  const FrameRange all = AllFrames(recording.run);
  return MakeComparison(recording.cameras, std::move(recording.options),
                        std::move(recording.run), {{all, prepared}},
                        std::nullopt, request.threads);
}

// Adds the recording's name to errors.
void ForRecording(const RecordingInput& input,
                  const std::function<void()>& work) {
  const std::string refusal = RefusalOf(work);
  if (refusal.empty()) return;
  throw InputError("recording '" + Printable(input.name) + "': " + refusal);
}

void AddErrors(const Comparison& comparison, const Strategy& strategy,
               StrategyPoints* points) {
  points->errors.push_back(
      ScoreGrid(comparison, strategy, points->points).errors[0][0]);
}

StudyScore ScoreOf(const Comparison& comparison, const StrategyScores& own,
                   const StrategyScores& baseline, bool is_baseline) {
  StudyScore score;
  score.refused = own.refused;
  if (!score.refused.empty()) return score;
  const BootstrapOptions bootstrap = comparison.bootstrap();
  score.mean_px = PooledRatio({own.held_out_errors});
  score.standard_error_px =
      RatioInterval(PooledRatio, {own.held_out_errors}, bootstrap)
          .standard_error;
  if (is_baseline) return score;
  score.difference_px = score.mean_px - PooledRatio({baseline.held_out_errors});
  const Interval interval =
      PairedInterval(PooledRatio, {own.held_out_errors},
                     {baseline.held_out_errors}, bootstrap);
  score.difference_error_px = interval.standard_error;
  score.verdict = VerdictOf(interval);
  return score;
}

// Computes a study.
class Maker {
 public:
  explicit Maker(const StudyRequest& request)
      : request_(request),
        chosen_(request.recordings.size()),
        defaults_(request.recordings.size()) {
    study_.strategies = request.strategies;
    study_.baseline_idx = request.baseline_idx;
    study_.tuned = request.tune;
  }

  Study Make() {
    if (request_.tune) EvaluateGrids();
    for (size_t t = 0; t < request_.recordings.size(); ++t) {
      ForRecording(request_.recordings[t], [&] { ScoreRecording(t); });
    }
    Choose();
    return std::move(study_);
  }

 private:
  // Evaluates every grid on every recording.
  void EvaluateGrids() {
    const std::vector<Strategy> tuned = TunedThemselves(request_.strategies);
    for (const Strategy& one : tuned) grids_[one.name].points = GridOf(one);
    Progress progress("tuning", static_cast<int64_t>(
                                    request_.recordings.size() * tuned.size()));
    for (const RecordingInput& input : request_.recordings) {
      ForRecording(input, [&] {
        const Comparison comparison =
            ComparisonOf(FreezeRecording(input, request_.threads), request_);
        for (const Strategy& one : tuned) {
          AddErrors(comparison, one, &grids_[one.name]);
          progress.Advance();
        }
      });
    }
  }

  // The best values on all recordings except `left_out` (-1: none is left out);
  // `defaults` without tuning, or if no values could be run on all of them.
  StrategyValues ValuesOf(size_t s, int left_out,
                          const StrategyValues& defaults) const {
    if (!request_.tune) return defaults;
    const StrategyPoints& grid =
        grids_.at(TunedAs(request_.strategies[s]).name);
    const auto best = BestPoint(grid.errors, left_out);
    return best ? grid.points[*best] : defaults;
  }

  // All values chosen for a strategy, each once.
  std::vector<StrategyValues> Wanted(size_t s,
                                     const StrategyValues& defaults) const {
    std::vector<StrategyValues> wanted;
    const int recordings = static_cast<int>(request_.recordings.size());
    for (int left_out = -1; left_out < recordings; ++left_out) {
      const StrategyValues values = ValuesOf(s, left_out, defaults);
      if (std::find(wanted.begin(), wanted.end(), values) == wanted.end()) {
        wanted.push_back(values);
      }
    }
    return wanted;
  }

  void ScoreRecording(size_t t) {
    const Comparison comparison = ComparisonOf(
        FreezeRecording(request_.recordings[t], request_.threads), request_);
    std::vector<FoldValues> values;
    for (size_t s = 0; s < request_.strategies.size(); ++s) {
      const StrategyValues defaults =
          DefaultValues(request_.strategies[s], comparison.rate_hz(),
                        comparison.options.estimators);
      values.push_back({ValuesOf(s, static_cast<int>(t), defaults)});
      defaults_[t].push_back(defaults);
      StrategyPoints& chosen = chosen_[t].emplace_back();
      chosen.points = Wanted(s, defaults);
      AddErrors(comparison, request_.strategies[s], &chosen);
    }
    StudyRecording recording;
    recording.name = request_.recordings[t].name;
    const std::vector<StrategyScores> scores = ScoreStrategies(
        comparison, request_.strategies, values, "scoring " + recording.name);
    const StrategyScores& baseline = scores[request_.baseline_idx];
    if (!baseline.refused.empty()) {
      throw InputError("the baseline cannot be run: " + baseline.refused);
    }
    for (size_t s = 0; s < scores.size(); ++s) {
      recording.scores.push_back(
          ScoreOf(comparison, scores[s], baseline, s == request_.baseline_idx));
      recording.scores.back().values = values[s].front();
    }
    study_.recordings.push_back(std::move(recording));
    if (t == 0) {
      const RecordingInput& first = request_.recordings[t];
      study_.options = ReadRunOptions(FindConfig(first.config),
                                      first.common_set, first.mode);
      study_.rate_hz = comparison.rate_hz();
    }
  }

  // The strategy that is best on all recordings except `left_out`. Each
  // strategy runs with the values chosen on those recordings and is one point
  // for BestPoint.
  std::optional<size_t> BestStrategy(int left_out) const {
    std::vector<PointErrors> recordings(request_.recordings.size());
    for (size_t s = 0; s < request_.strategies.size(); ++s) {
      for (size_t t = 0; t < recordings.size(); ++t) {
        // Defaults, and so the order of the points, depend on the recording.
        const std::vector<StrategyValues>& points = chosen_[t][s].points;
        const PointErrors& errors = chosen_[t][s].errors.front();
        const StrategyValues values = ValuesOf(s, left_out, defaults_[t][s]);
        const auto point = static_cast<size_t>(
            std::find(points.begin(), points.end(), values) - points.begin());
        recordings[t].push_back(point < errors.size() ? errors[point]
                                                      : RatioUnit());
      }
    }
    return BestPoint(recordings, left_out);
  }

  void Choose() {
    for (size_t t = 0; t < study_.recordings.size(); ++t) {
      study_.recordings[t].chosen = BestStrategy(static_cast<int>(t));
    }
    study_.best = BestStrategy(-1);
    if (study_.best) {
      study_.best_values =
          ValuesOf(*study_.best, -1, defaults_[0][*study_.best]);
    }
  }

  const StudyRequest& request_;
  std::map<std::string, StrategyPoints> grids_;
  // By recording and requested strategy; `errors` is of that recording only.
  std::vector<std::vector<StrategyPoints>> chosen_;
  std::vector<std::vector<StrategyValues>> defaults_;
  Study study_;
};

// ---- Output

// Mean error of one strategy by recording; no value where it could not be run.
BatchColumn StudyMeans(const Study& study, size_t s) {
  BatchColumn column;
  for (const StudyRecording& recording : study.recordings) {
    const StudyScore& score = recording.scores[s];
    column.emplace_back();
    if (!score.refused.empty() || !std::isfinite(score.mean_px)) continue;
    column.back() = BatchValue{score.mean_px, score.standard_error_px};
  }
  return column;
}

// The difference from the baseline: of one strategy or (nullopt), in each
// recording, of the strategy chosen on the other recordings.
BatchSummary DifferenceOf(const Study& study, std::optional<size_t> strategy) {
  BatchColumn column;
  for (const StudyRecording& recording : study.recordings) {
    column.emplace_back();
    const std::optional<size_t> s = strategy ? strategy : recording.chosen;
    if (!s || !recording.scores[*s].refused.empty()) continue;
    column.back() = BatchValue{recording.scores[*s].difference_px,
                               recording.scores[*s].difference_error_px};
  }
  return Summarise(column);
}

// "better on 3, no significant difference on 1, worse on 0 of 4 recordings"
std::string Counts(const StudyVerdict& verdict) {
  return fmt::format(
      "better on {}, no significant difference on {}, worse on {} of {} "
      "recordings",
      verdict.better, verdict.same, verdict.worse, verdict.recordings);
}

std::string VerdictSentences(const Study& study) {
  if (!study.best) return "No strategy could be run on every recording.";
  const StudyVerdict verdict = HoldsFor(study);
  const Strategy& best = study.strategies[*study.best];
  std::string text = "Best over all recordings: " + best.title;
  if (!study.best_values.empty()) {
    text += " (" + DescribeValues(best, study.best_values) + ")";
  }
  text += fmt::format(
      ". Leave-one-out: each recording was scored with the strategy and values "
      "chosen on the others. Compared with {}, the choice was {}; it was this "
      "same strategy for {} of {} recordings.",
      study.strategies[study.baseline_idx].title, Counts(verdict),
      verdict.like_all, verdict.recordings);
  const BatchSummary difference = DifferenceOf(study, std::nullopt);
  if (difference.recordings > 0) {
    text += " Mean difference " + SummaryCell(difference, 2) +
            " px (95 % interval; bootstrap over recordings and frames).";
  }
  return text;
}

// One row per strategy: mean error, difference from the baseline, and numbers
// of recordings on which it is better, not significantly different, and worse.
Table StrategyTable(const Study& study) {
  Table table({"strategy", "held-out, px", "vs. baseline, px",
               "better / same / worse"});
  for (size_t s = 0; s < study.strategies.size(); ++s) {
    StudyVerdict counts;
    for (const StudyRecording& recording : study.recordings) {
      const StudyScore& score = recording.scores[s];
      if (score.refused.empty()) counts.Count(score.verdict);
    }
    const bool is_baseline = s == study.baseline_idx;
    table.AddRow({study.strategies[s].title,
                  SummaryCell(Summarise(StudyMeans(study, s)), 2),
                  is_baseline ? "-" : SummaryCell(DifferenceOf(study, s), 2),
                  is_baseline ? "-"
                              : fmt::format("{} / {} / {}", counts.better,
                                            counts.same, counts.worse)});
  }
  return table;
}

Table RecordingTable(const Study& study) {
  Table table({"recording", "chosen on the others", "values", "held-out, px",
               "vs. baseline, px", ""});
  for (const StudyRecording& recording : study.recordings) {
    if (!recording.chosen) {
      table.AddRow({recording.name, "-", "-", "-", "-", ""});
      continue;
    }
    const StudyScore& score = recording.scores[*recording.chosen];
    const Strategy& strategy = study.strategies[*recording.chosen];
    table.AddRow({recording.name, strategy.title,
                  DescribeValues(strategy, score.values),
                  score.refused.empty() ? Fixed(score.mean_px, 2) : "refused",
                  score.refused.empty() ? Fixed(score.difference_px, 2) : "-",
                  ToString(score.verdict)});
  }
  return table;
}

Json ScoreJson(const StudyScore& score) {
  if (!score.refused.empty()) return {{"refused", score.refused}};
  return {{"values", score.values},
          {"held_out_mean_px", score.mean_px},
          {"standard_error_px", score.standard_error_px},
          {"difference_px", score.difference_px},
          {"difference_standard_error_px", score.difference_error_px},
          {"verdict", ToString(score.verdict)}};
}

}  // namespace

std::optional<size_t> BestPoint(const std::vector<PointErrors>& recordings,
                                int left_out) {
  std::optional<size_t> best;
  double least = kNan;
  const size_t points = recordings.empty() ? 0 : recordings.front().size();
  for (size_t point = 0; point < points; ++point) {
    double sum = 0.0;
    int count = 0;
    for (size_t t = 0; t < recordings.size(); ++t) {
      if (static_cast<int>(t) == left_out) continue;
      const RatioUnit& unit = recordings[t][point];
      sum += unit.weight > 0.0 ? unit.sum / unit.weight : kNan;
      ++count;
    }
    const double mean = count > 0 ? sum / count : kNan;
    if (std::isnan(mean) || (best && mean >= least)) continue;
    best = point;
    least = mean;
  }
  return best;
}

StudyVerdict HoldsFor(const Study& study) {
  StudyVerdict verdict;
  for (const StudyRecording& recording : study.recordings) {
    if (!recording.chosen ||
        !recording.scores[*recording.chosen].refused.empty())
      continue;
    ++verdict.recordings;
    if (recording.chosen == study.best) ++verdict.like_all;
    verdict.Count(recording.scores[*recording.chosen].verdict);
  }
  return verdict;
}

Study RunStudy(const StudyRequest& request) { return Maker(request).Make(); }

std::string StudyMarkdown(const Study& study) {
  return "# A comparison over " + std::to_string(study.recordings.size()) +
         " recordings\n\n" + VerdictSentences(study) +
         "\n\nHeld-out error: mean of min(error, 30 px) of the detections of "
         "each camera, left out in turn. " +
         (study.tuned ? "Values of every strategy are chosen on the other "
                        "recordings. "
                      : "Values are the configuration's. ") +
         "Each recording has the same weight. 95 % intervals come from a "
         "bootstrap that resamples recordings and perturbs the value of each "
         "recording by its own bootstrap error over frames.\n\n" +
         StrategyTable(study).ToString(TableStyle::kMarkdown) +
         "\nbetter / same / worse: number of recordings on which the 95 % "
         "interval of the paired difference from the baseline lies below zero, "
         "contains zero, or lies above zero.\n\n## Results by "
         "recording\n\n" +
         RecordingTable(study).ToString(TableStyle::kMarkdown);
}

std::string StudyCsv(const Study& study) {
  Table table({"take", "strategy", "values", "held_out_mean_px",
               "standard_error_px", "difference_px",
               "difference_standard_error_px", "verdict", "chosen"});
  for (const StudyRecording& recording : study.recordings) {
    for (size_t s = 0; s < study.strategies.size(); ++s) {
      const StudyScore& score = recording.scores[s];
      const bool ran = score.refused.empty();
      const auto figure = [&](double value) {
        return ran ? Fixed(value, 6) : "";
      };
      table.AddRow({recording.name, study.strategies[s].name,
                    DescribeValues(study.strategies[s], score.values),
                    figure(score.mean_px), figure(score.standard_error_px),
                    figure(score.difference_px),
                    figure(score.difference_error_px),
                    ran ? ToString(score.verdict) : "refused",
                    recording.chosen == s ? "1" : "0"});
    }
  }
  return table.ToString(TableStyle::kCsv);
}

std::string StudyJson(const Study& study) {
  Json json;
  const StudyVerdict verdict = HoldsFor(study);
  json["baseline"] = study.strategies[study.baseline_idx].name;
  json["tuned"] = study.tuned;
  json["best"] =
      study.best ? Json(study.strategies[*study.best].name) : nullptr;
  json["best_values"] = study.best_values;
  json["holds"] = {
      {"takes", verdict.recordings},
      {"better", verdict.better},
      {"not_told_apart", verdict.same},
      {"worse", verdict.worse},
      {"same_strategy", verdict.like_all},
      {"difference_px", SummaryJson(DifferenceOf(study, std::nullopt))}};
  for (size_t s = 0; s < study.strategies.size(); ++s) {
    json["strategies"][study.strategies[s].name] = {
        {"held_out_mean_px", SummaryJson(Summarise(StudyMeans(study, s)))},
        {"difference_px", SummaryJson(DifferenceOf(study, s))}};
  }
  for (const StudyRecording& recording : study.recordings) {
    Json& one = json["takes"][recording.name];
    one["chosen_on_the_others"] =
        recording.chosen ? Json(study.strategies[*recording.chosen].name)
                         : nullptr;
    for (size_t s = 0; s < study.strategies.size(); ++s) {
      one["strategies"][study.strategies[s].name] =
          ScoreJson(recording.scores[s]);
    }
  }
  return DumpJson(json, 1) + "\n";
}

std::string StudyToml(const Study& study) {
  if (!study.best) return "";
  RunOptions wanted = study.options;
  wanted.estimators =
      OptionsOfStrategy(study.strategies[*study.best], study.best_values,
                        study.rate_hz, wanted.estimators);
  return "# Made by `kinegraph compare --manifest`: the configuration it was "
         "given, with the\n# strategy that is best over " +
         std::to_string(study.recordings.size()) + " recordings, " +
         study.strategies[*study.best].title +
         ".\n# Chosen on the other recordings and scored on the one left "
         "out: " +
         Counts(HoldsFor(study)) + ".\n" + ChangedKeysToml(wanted);
}

std::string StudyDigest(const Study& study, const std::string& folder) {
  return StrategyTable(study).ToString() + "\n" +
         RecordingTable(study).ToString() + "\n" +
         Wrapped(VerdictSentences(study), kTerminalColumns) + "written to " +
         folder +
         ":\n  study.md, study.csv, study.json\n  recommended.toml: your "
         "configuration with the best strategy, for track --config\n";
}

}  // namespace kinegraph
