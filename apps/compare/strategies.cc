#include "apps/compare/strategies.h"

#include <fmt/format.h>
#include <glog/logging.h>

#include <algorithm>
#include <utility>

#include "apps/common/table.h"
#include "core/base/error.h"

namespace kinegraph {
namespace {

// The strategy applied to robustly triangulated points.
Strategy OnRobustPoints(Strategy strategy) {
  strategy.name += "_robust";
  strategy.title += ", on robust triangulation";
  strategy.fix = [fix = strategy.fix](double rate_hz,
                                      EstimatorOptions* options) {
    if (fix) fix(rate_hz, options);
    options->filters.points = PointKind::kRobust;
  };
  return strategy;
}

bool OfTheGraph(OutputKind kind) {
  return kind == OutputKind::kWindow || kind == OutputKind::kBatch;
}

// In the order of the report: filters of triangulated points, some of them
// again on robustly triangulated points, then the graph's strategies.
std::vector<Strategy> MakeTable() {
  std::vector<Strategy> table;
  std::vector<Strategy> robust;
  std::vector<Strategy> graph;
  for (const Smoother& smoother : Smoothers()) {
    for (const SmootherVariant& variant : smoother.variants) {
      const Strategy strategy = {variant, smoother.kind};
      (OfTheGraph(smoother.kind) ? graph : table).push_back(strategy);
      if (variant.also_on_robust_points) {
        robust.push_back(OnRobustPoints(strategy));
      }
    }
  }
  table.insert(table.end(), robust.begin(), robust.end());
  table.insert(table.end(), graph.begin(), graph.end());
  return table;
}

// The filters with a cut-off, each with every rule that chooses the cut-off
// frequency. AllStrategies() contains some of these under other names.
std::vector<Strategy> ByRules() {
  std::vector<Strategy> strategies;
  for (const OutputKind kind :
       {OutputKind::kButterworth, OutputKind::kCriticallyDamped,
        OutputKind::kSmoothingSpline, OutputKind::kQuinticSpline,
        OutputKind::kWhittaker}) {
    const Smoother& smoother = SmootherOf(kind);
    for (const auto& [name, rule] : CutoffRules()) {
      Strategy& strategy = strategies.emplace_back();
      strategy.kind = kind;
      strategy.name = smoother.name + "_" + name;
      strategy.title = smoother.name + ", rule " + name;
      strategy.fix = [rule = rule](double, EstimatorOptions* options) {
        options->filters.butterworth.choice = rule;
        options->filters.butterworth.on = FilterSignal::kPosition;
        options->filters.smoothing_spline.choice = rule;
      };
    }
  }
  return strategies;
}

}  // namespace

const std::vector<Strategy>& AllStrategies() {
  static const std::vector<Strategy> table = MakeTable();
  return table;
}

std::vector<Strategy> ChooseStrategies(const std::vector<std::string>& names) {
  if (names.empty()) return AllStrategies();
  std::vector<Strategy> all = AllStrategies();
  for (Strategy& strategy : ByRules()) all.push_back(std::move(strategy));
  std::vector<Strategy> chosen;
  for (const std::string& name : names) {
    const size_t at = IndexOf(all, name);
    if (at == all.size()) {
      const Cells known =
          CellsOf(all, [](const Strategy& one) { return one.name; });
      throw InputError(
          fmt::format("no strategy is named '{}', expected one of {}",
                      Printable(name), fmt::join(known, ", ")));
    }
    if (IndexOf(chosen, name) < chosen.size()) {
      throw InputError("strategy '" + name + "' is named twice");
    }
    chosen.push_back(all[at]);
  }
  return chosen;
}

const std::vector<std::pair<std::string, CutoffChoice>>& CutoffRules() {
  static const std::vector<std::pair<std::string, CutoffChoice>> rules = {
      {"winter", CutoffChoice::kWinter},  {"challis", CutoffChoice::kChallis},
      {"yu", CutoffChoice::kYu},          {"jackson", CutoffChoice::kJackson},
      {"gcv", CutoffChoice::kGcv},        {"power95", CutoffChoice::kPower95},
      {"power99", CutoffChoice::kPower99}};
  return rules;
}

size_t IndexOf(const std::vector<Strategy>& strategies,
               const std::string& name) {
  const auto at =
      std::find_if(strategies.begin(), strategies.end(),
                   [&name](const Strategy& one) { return one.name == name; });
  return static_cast<size_t>(at - strategies.begin());
}

const Strategy& TunedAs(const Strategy& strategy) {
  if (strategy.tuned_as.empty()) return strategy;
  const std::vector<Strategy>& all = AllStrategies();
  const size_t at = IndexOf(all, strategy.tuned_as);
  CHECK_LT(at, all.size()) << strategy.tuned_as;
  CHECK_EQ(all[at].parameters.size(), strategy.parameters.size());
  return all[at];
}

std::vector<Strategy> TunedThemselves(const std::vector<Strategy>& strategies) {
  std::vector<Strategy> tuned;
  for (const Strategy& strategy : strategies) {
    const Strategy& one = TunedAs(strategy);
    if (IndexOf(tuned, one.name) == tuned.size()) tuned.push_back(one);
  }
  return tuned;
}

StrategyValues DefaultValues(const Strategy& strategy, double rate_hz,
                             const EstimatorOptions& options) {
  EstimatorOptions fixed = options;
  if (strategy.fix) strategy.fix(rate_hz, &fixed);
  StrategyValues values;
  for (const SmootherParameter& parameter : strategy.parameters) {
    values.push_back(parameter.get(fixed));
  }
  return values;
}

EstimatorOptions OptionsOfStrategy(const Strategy& strategy,
                                   const StrategyValues& values, double rate_hz,
                                   EstimatorOptions options) {
  CHECK_EQ(values.size(), strategy.parameters.size()) << strategy.name;
  if (strategy.fix) strategy.fix(rate_hz, &options);
  for (size_t i = 0; i < values.size(); ++i) {
    strategy.parameters[i].set(values[i], &options);
  }
  options.mode = Mode::kGraph;
  options.output = strategy.kind;
  return options;
}

EstimatorFactory MakeStrategy(const Strategy& strategy,
                              const StrategyValues& values, double rate_hz,
                              const EstimatorOptions& options) {
  return MakeOutput(strategy.kind,
                    OptionsOfStrategy(strategy, values, rate_hz, options));
}

bool IsCausalStrategy(const Strategy& strategy, const StrategyValues& values,
                      double rate_hz, const EstimatorOptions& options) {
  return IsCausal(strategy.kind,
                  OptionsOfStrategy(strategy, values, rate_hz, options));
}

std::vector<StrategyValues> GridOf(const Strategy& strategy) {
  std::vector<StrategyValues> grid = {{}};
  for (const SmootherParameter& parameter : strategy.parameters) {
    std::vector<StrategyValues> longer;
    for (const StrategyValues& values : grid) {
      for (const double value : parameter.grid) {
        longer.push_back(values);
        longer.back().push_back(value);
      }
    }
    grid = std::move(longer);
  }
  return grid;
}

std::string DescribeValues(const Strategy& strategy,
                           const StrategyValues& values) {
  Cells texts;
  for (size_t i = 0; i < values.size(); ++i) {
    texts.push_back(
        fmt::format("{} {:.4g}", strategy.parameters[i].name, values[i]));
  }
  return texts.empty() ? "-" : fmt::format("{}", fmt::join(texts, ", "));
}

}  // namespace kinegraph
