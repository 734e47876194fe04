// The smoothing strategies of `compare`: the variants of every smoother
// (solvers/smoothers.h).
#ifndef KINEGRAPH_APPS_COMPARE_STRATEGIES_H_
#define KINEGRAPH_APPS_COMPARE_STRATEGIES_H_

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "core/tracking/estimator.h"
#include "solvers/smoothers.h"

namespace kinegraph {

// A variant of a smoother, possibly applied to robustly triangulated points.
struct Strategy : SmootherVariant {
  Strategy() = default;
  Strategy(SmootherVariant variant, OutputKind of)
      : SmootherVariant(std::move(variant)), kind(of) {}

  OutputKind kind = OutputKind::kGaussian;
};

// All strategies that run by default, in the order of output.
const std::vector<Strategy>& AllStrategies();
// The named strategies, in the order of `names`; without names AllStrategies.
// Filters with a cut-off also exist with each rule that chooses the cut-off
// frequency (CutoffRules), for example "whittaker_yu"; these run only if named.
// Throws InputError for unknown and repeated names.
std::vector<Strategy> ChooseStrategies(const std::vector<std::string>& names);

// The rules that choose a cut-off frequency: "winter", ..., as in
// filters.*.choice.
const std::vector<std::pair<std::string, CutoffChoice>>& CutoffRules();

// Index of the strategy with this name; strategies.size() if there is none.
size_t IndexOf(const std::vector<Strategy>& strategies,
               const std::string& name);
// The strategy whose tuned values this strategy uses, usually itself.
const Strategy& TunedAs(const Strategy& strategy);
// The strategies whose grids must be evaluated for `strategies`, each once.
std::vector<Strategy> TunedThemselves(const std::vector<Strategy>& strategies);

inline constexpr const char* kDefaultBaseline = "causal_gaussian";
inline constexpr const char* kOfflineReference = "batch";

// The values of a strategy's parameters.
using StrategyValues = std::vector<double>;

StrategyValues DefaultValues(const Strategy& strategy, double rate_hz,
                             const EstimatorOptions& options);
// The options of graph mode with which `track` writes this strategy's poses.
EstimatorOptions OptionsOfStrategy(const Strategy& strategy,
                                   const StrategyValues& values, double rate_hz,
                                   EstimatorOptions options);
EstimatorFactory MakeStrategy(const Strategy& strategy,
                              const StrategyValues& values, double rate_hz,
                              const EstimatorOptions& options);
// Whether a pose depends only on frames up to its own.
bool IsCausalStrategy(const Strategy& strategy, const StrategyValues& values,
                      double rate_hz, const EstimatorOptions& options);
// All combinations of the grids, the last parameter fastest.
std::vector<StrategyValues> GridOf(const Strategy& strategy);
// "cutoff_hz 4, order 2"; "-" without parameters.
std::string DescribeValues(const Strategy& strategy,
                           const StrategyValues& values);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMPARE_STRATEGIES_H_
