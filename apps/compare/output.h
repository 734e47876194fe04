// Writes a comparison as files and text: tables (output.cc), conclusions
// (verdict.cc), figures (plots.cc).
#ifndef KINEGRAPH_APPS_COMPARE_OUTPUT_H_
#define KINEGRAPH_APPS_COMPARE_OUTPUT_H_

#include <string>
#include <vector>

#include "apps/compare/cutoffs.h"
#include "apps/compare/scores.h"
#include "core/io/text/json.h"

namespace kinegraph {

// Measures, balance by joint, tuning and lag sweep; no run times, which vary.
Json CompareJson(const CompareResult& result);
// Tidy: one row per strategy and measure.
std::string CompareCsv(const CompareResult& result);
// One row per scored joint: its frame and each strategy's held-out error [px];
// empty without a prediction and for errors of cap_px or more.
std::string ErrorsCsv(const CompareResult& result);
// One row per strategy, joint ("all": together) and subset of the frames:
// errors of velocity and acceleration. Requires a ground truth.
std::string DerivativesCsv(const CompareResult& result);
std::string CompareMarkdown(const CompareResult& result,
                            const std::vector<ChosenCutoff>& cutoffs);

// Processor time of each strategy.
Json RuntimeJson(const CompareResult& result);
std::string RuntimeTable(const CompareResult& result);

// Lists the strategies that are better than the baseline by held-out error, not
// significantly different (the interval of the difference contains zero), and
// worse; then the same for the joints that every strategy predicts.
std::string RankingText(const CompareResult& result);

// The strategies that remove motion or keep noise significantly, with the
// joints; at most two sentences.
std::vector<std::string> BalanceSentences(const CompareResult& result);

// Sentences: the best strategy, how certain that is, its delay and, with a
// ground truth, the strategy nearest to the truth.
std::string VerdictText(const CompareResult& result);

// recommended.toml: the comparison's configuration with the strategy that has
// the smallest mean held-out error; keys at their defaults are left out. Empty
// if nothing could be scored.
std::string RecommendedToml(const CompareResult& result);

// The keys of `options` that differ from their defaults, one per line.
std::string ChangedKeysToml(const RunOptions& options);

// For a terminal, at most 100 columns: one row per strategy, the verdict,
// BalanceSentences, and the files of `folder` that hold the rest.
std::string Digest(const CompareResult& result, const std::string& folder);

// What is shown in plots that have no room for everything.
struct PlotChoice {
  // Names; unknown and refused ones are ignored, and if none is left, all
  // strategies that ran are shown.
  std::vector<std::string> strategies;
  std::string joint = "r_wrist";
};

// Writes SVG files into `folder` and returns their names.
std::vector<std::string> WriteComparePlots(
    const CompareResult& result, const std::vector<ChosenCutoff>& cutoffs,
    const PlotChoice& choice, const std::string& folder);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMPARE_OUTPUT_H_
