#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/batch/merge.h"
#include "apps/common/table.h"
#include "apps/compare/output.h"
#include "apps/compare/study.h"
#include "core/io/text/json.h"

namespace kinegraph {
namespace {

// One strategy on all recordings that it ran on.
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

// The difference to the baseline of one strategy, or (nullopt) of the one that
// was chosen without each recording.
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

std::string Cell(const BatchSummary& summary) {
  if (summary.recordings == 0) return "-";
  return WithInterval(summary.mean, summary.interval, 2);
}

// "better on 3, not told apart on 1, worse on 0 of 4 recordings"
std::string Counts(const StudyVerdict& verdict) {
  return fmt::format(
      "better on {}, not told apart on {}, worse on {} of {} recordings",
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
      ". Left out in turn, each of the recordings was scored with what the "
      "others chose: against {} it was {}; {} of {} chose the same strategy.",
      study.strategies[study.baseline_idx].title, Counts(verdict),
      verdict.like_all, verdict.recordings);
  const BatchSummary difference = DifferenceOf(study, std::nullopt);
  if (difference.recordings > 0) {
    text += " Mean difference " + Cell(difference) +
            " px (95 %, over recordings, then frames).";
  }
  return text;
}

// Strategy by strategy: mean, difference, and on how many recordings.
Table StrategyTable(const Study& study) {
  Table table(
      {"strategy", "held-out, px", "to baseline, px", "better / same / worse"});
  for (size_t s = 0; s < study.strategies.size(); ++s) {
    int counts[3] = {0, 0, 0};
    for (const StudyRecording& recording : study.recordings) {
      const StudyScore& score = recording.scores[s];
      if (!score.refused.empty()) continue;
      ++counts[score.verdict == Verdict::kLess   ? 0
               : score.verdict == Verdict::kMore ? 2
                                                 : 1];
    }
    const bool is_baseline = s == study.baseline_idx;
    table.AddRow(
        {study.strategies[s].title, Cell(Summarise(StudyMeans(study, s))),
         is_baseline ? "-" : Cell(DifferenceOf(study, s)),
         is_baseline
             ? "-"
             : fmt::format("{} / {} / {}", counts[0], counts[1], counts[2])});
  }
  return table;
}

Table RecordingTable(const Study& study) {
  Table table({"take", "chosen on the others", "values", "held-out, px",
               "to baseline, px", ""});
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

std::string StudyMarkdown(const Study& study) {
  return "# A comparison over " + std::to_string(study.recordings.size()) +
         " takes\n\n" + VerdictSentences(study) +
         "\n\nHeld-out error: mean of min(error, 30 px) of the detections of "
         "each camera, left out in turn. " +
         (study.tuned ? "Values of every strategy are chosen on the other "
                        "recordings. "
                      : "Values are the configuration's. ") +
         "Each recording counts the same. Intervals (95 %) draw recordings, "
         "and each "
         "recording's figure with the error of its own bootstrap over "
         "frames.\n\n" +
         StrategyTable(study).ToString(TableStyle::kMarkdown) +
         "\nbetter / same / worse: recordings on which the interval of the "
         "paired "
         "difference to the baseline is clear of zero, or is not.\n\n## Take "
         "by recording\n\n" +
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
         ":\n  study.md, study.csv, study.json\n  recommended.toml: for track "
         "--config, the configuration given with the best strategy\n";
}

}  // namespace kinegraph
