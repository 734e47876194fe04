// The smoothing strategies that `compare` knows: one table. A strategy is a
// name and a change of the estimators' options; what may be tuned stands beside
// it.
#ifndef KINEGRAPH_APPS_COMPARE_STRATEGIES_H_
#define KINEGRAPH_APPS_COMPARE_STRATEGIES_H_

#include <functional>
#include <string>
#include <vector>

#include "core/base/frame_range.h"
#include "core/base/options.h"
#include "core/tracking/estimator.h"
#include "solvers/factory.h"

namespace kinegraph {

// A number that is chosen by held-out error.
struct StrategyParameter {
  std::string name;  // key of a file of parameters
  std::string unit;
  std::vector<double> grid;  // ascending
  bool log = false;          // drawn on a log axis
  std::function<void(double, EstimatorOptions*)> set;
  // What it is if nobody tells: as the configuration says.
  std::function<double(const EstimatorOptions&)> get;
};

struct Strategy {
  std::string name;   // "butterworth"
  std::string title;  // "Butterworth, zero phase"
  OutputKind kind = OutputKind::kGaussian;
  // Fixes what makes it this strategy; may be empty.
  std::function<void(double rate_hz, EstimatorOptions*)> fix;
  // One or two.
  std::vector<StrategyParameter> parameters;
  // Takes the values of this one, which has the same parameters and minimises
  // the same cost, instead of being tuned itself.
  std::string tuned_as;
  // Frames that a window keeps; -1: no window.
  int lag_frames = -1;
};

// All of them, in the order in which they are printed.
const std::vector<Strategy>& AllStrategies();
// Those named, in that order; no name: all. Throws InputError for an unknown or
// repeated one.
std::vector<Strategy> ChooseStrategies(const std::vector<std::string>& names);

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
