// The smoothing strategies of `compare`: the variants of every smoother
// (solvers/smoothers.h).
#ifndef KINEGRAPH_APPS_COMPARE_STRATEGIES_H_
#define KINEGRAPH_APPS_COMPARE_STRATEGIES_H_

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "core/base/frame_range.h"
#include "core/base/options.h"
#include "core/tracking/estimator.h"
#include "solvers/smoothers.h"

namespace kinegraph {

// A variant of a smoother, possibly on other points.
struct Strategy : SmootherVariant {
  Strategy() = default;
  Strategy(SmootherVariant variant, OutputKind of)
      : SmootherVariant(std::move(variant)), kind(of) {}

  OutputKind kind = OutputKind::kGaussian;
};

// All of them, in the order of output.
const std::vector<Strategy>& AllStrategies();
// The named ones in that order; without names all. Filters with a cut-off also
// exist with each rule, as "whittaker_yu", and run only if named. Throws
// InputError for an unknown or repeated one.
std::vector<Strategy> ChooseStrategies(const std::vector<std::string>& names);

// The rules of a cut-off: "winter", ..., as in filters.*.choice.
const std::vector<std::pair<std::string, CutoffChoice>>& CutoffRules();

// Index of a name among `strategies`; their number if absent.
size_t IndexOf(const std::vector<Strategy>& strategies,
               const std::string& name);
// The strategy whose tuned values this one takes, usually itself.
const Strategy& TunedAs(const Strategy& strategy);
// The strategies whose grids must be evaluated for `strategies`, each once.
std::vector<Strategy> TunedThemselves(const std::vector<Strategy>& strategies);

inline constexpr const char* kDefaultBaseline = "causal_gaussian";
inline constexpr const char* kOfflineReference = "batch";

// The values of a strategy's parameters.
using StrategyValues = std::vector<double>;

StrategyValues DefaultValues(const Strategy& strategy, double rate_hz,
                             const EstimatorOptions& options);
// Options of graph mode for which this strategy's poses are written.
EstimatorOptions OptionsOfStrategy(const Strategy& strategy,
                                   const StrategyValues& values, double rate_hz,
                                   EstimatorOptions options);
EstimatorFactory MakeStrategy(const Strategy& strategy,
                              const StrategyValues& values, double rate_hz,
                              EstimatorOptions options);
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
