// A comparison as files and for people: tables (output.cc), what it ends with
// (verdict.cc), pictures (plots.cc).
#ifndef KINEGRAPH_APPS_COMPARE_OUTPUT_H_
#define KINEGRAPH_APPS_COMPARE_OUTPUT_H_

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "apps/compare/cutoffs.h"
#include "apps/compare/scores.h"
#include "core/io/text/json.h"

namespace kinegraph {

// Everything but run times, which differ each time.
Json CompareJson(const CompareResult& result);
// Tidy: one row a strategy and measure.
std::string CompareCsv(const CompareResult& result);
// One row a scored joint: its frame and each strategy's held-out error [px],
// empty without a prediction.
std::string ErrorsCsv(const CompareResult& result);
// One row a strategy, joint ("all": together) and part of the frames: errors of
// velocity and acceleration. Only with a truth.
std::string DerivativesCsv(const CompareResult& result);
std::string CompareMarkdown(const CompareResult& result,
                            const std::vector<ChosenCutoff>& cutoffs);

// Processor time of each strategy.
Json RuntimeJson(const CompareResult& result);
std::string RuntimeTable(const CompareResult& result);

// Who is better and worse than the baseline by held-out error, in sentences: a
// strategy is named only where the interval of the difference is clear of zero.
std::string RankingText(const CompareResult& result);

// Which strategy to use, how sure that is, and what it costs, in sentences.
std::string VerdictText(const CompareResult& result);

// recommended.toml: the configuration that the comparison was given, with the
// strategy of the least mean held-out error; keys at their defaults are left
// out. Empty when nothing could be scored.
std::string RecommendedToml(const CompareResult& result);

// The keys of `options` that differ from their defaults, a line each.
std::string ChangedKeysToml(const RunOptions& options);

// For a terminal, at most 100 columns: a row a strategy, the verdict, and the
// files of `folder` that hold the rest.
std::string Digest(const CompareResult& result, const std::string& folder);

// What is drawn where not all strategies fit.
struct PlotChoice {
  std::vector<std::string> strategies;  // by name; those that are there
  std::string joint = "r_wrist";
};

// Writes SVG files into `folder` and returns their names.
std::vector<std::string> WriteComparePlots(
    const CompareResult& result, const std::vector<ChosenCutoff>& cutoffs,
    const PlotChoice& choice, const std::string& folder);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMPARE_OUTPUT_H_
