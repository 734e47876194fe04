// The smoothing strategies that `compare` knows: the variants of every smoother
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

// A variant of a smoother, or one on other points.
struct Strategy : SmootherVariant {
  Strategy() = default;
  Strategy(SmootherVariant variant, OutputKind of)
      : SmootherVariant(std::move(variant)), kind(of) {}

  OutputKind kind = OutputKind::kGaussian;
};

// All of them, in the order in which they are printed.
const std::vector<Strategy>& AllStrategies();
// Those named, in that order; no name: all. Filters with a cut-off are known
// with each rule, too, as "whittaker_yu", which are run by name alone. Throws
// InputError for an unknown or repeated one.
std::vector<Strategy> ChooseStrategies(const std::vector<std::string>& names);

// The rules of a cut-off: "winter", ..., as filters.*.choice takes them.
const std::vector<std::pair<std::string, CutoffChoice>>& CutoffRules();

// Where a name stands among `strategies`; their number where it does not.
size_t IndexOf(const std::vector<Strategy>& strategies,
               const std::string& name);
// The strategy whose tuned values this one takes: itself, mostly.
const Strategy& TunedAs(const Strategy& strategy);
// Those whose grids have to be walked for `strategies`, each once.
std::vector<Strategy> TunedThemselves(const std::vector<Strategy>& strategies);

inline constexpr const char* kDefaultBaseline = "causal_gaussian";
inline constexpr const char* kOfflineReference = "batch";

// The values of a strategy's parameters.
using StrategyValues = std::vector<double>;

StrategyValues DefaultValues(const Strategy& strategy, double rate_hz,
                             const EstimatorOptions& options);
// The options of graph mode that write this strategy's poses.
EstimatorOptions OptionsOfStrategy(const Strategy& strategy,
                                   const StrategyValues& values, double rate_hz,
                                   EstimatorOptions options);
EstimatorFactory MakeStrategy(const Strategy& strategy,
                              const StrategyValues& values, double rate_hz,
                              EstimatorOptions options);
// Whether a pose depends on nothing that came after its frame.
bool IsCausalStrategy(const Strategy& strategy, const StrategyValues& values,
                      double rate_hz, const EstimatorOptions& options);
// All combinations of the grids, the last parameter fastest.
std::vector<StrategyValues> GridOf(const Strategy& strategy);
// "cutoff_hz 4, order 2"; "-" without parameters.
std::string DescribeValues(const Strategy& strategy,
                           const StrategyValues& values);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMPARE_STRATEGIES_H_
