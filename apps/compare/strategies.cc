#include "apps/compare/strategies.h"

#include <glog/logging.h>

#include <algorithm>
#include <cstdio>
#include <utility>

#include "core/base/error.h"

namespace kinegraph {
namespace {

using Fix = std::function<void(double, EstimatorOptions*)>;

// A parameter that is one field of the options.
template <typename Access>
StrategyParameter Field(std::string name, std::string unit,
                        std::vector<double> grid, Access access) {
  StrategyParameter parameter;
  parameter.name = std::move(name);
  parameter.unit = std::move(unit);
  parameter.log = grid.front() > 0.0 && grid.back() / grid.front() >= 8.0;
  parameter.grid = std::move(grid);
  parameter.set = [access](double value, EstimatorOptions* options) {
    access(*options) = value;
  };
  parameter.get = [access](const EstimatorOptions& options) {
    EstimatorOptions copy = options;
    return access(copy);
  };
  return parameter;
}

// One factor on the whole table of process noise, which is then not learnt.
StrategyParameter GraphProcessNoise() {
  StrategyParameter parameter;
  parameter.name = "process_noise_factor";
  parameter.grid = {0.1, 0.3, 1.0, 3.0, 10.0, 30.0};
  parameter.log = true;
  parameter.set = [](double value, EstimatorOptions* options) {
    for (double& q : options->graph.process_noise) q *= value;
    options->graph.process_noise_from = NoiseFrom::kFixed;
  };
  parameter.get = [](const EstimatorOptions&) { return 1.0; };
  return parameter;
}

StrategyParameter GraphLossScale() {
  return Field(
      "loss_scale", "sigmas", {2.0, 3.0, 4.5, 7.0},
      [](EstimatorOptions& o) -> double& { return o.graph.loss_scale; });
}

Strategy Filter(std::string name, std::string title, OutputKind kind,
                std::vector<StrategyParameter> parameters = {},
                Fix fix = nullptr) {
  Strategy strategy;
  strategy.name = std::move(name);
  strategy.title = std::move(title);
  strategy.kind = kind;
  strategy.fix = std::move(fix);
  strategy.parameters = std::move(parameters);
  return strategy;
}

Strategy Window(int lag_frames) {
  Strategy strategy =
      Filter("window_" + std::to_string(lag_frames),
             "window, " + std::to_string(lag_frames) + " frames",
             OutputKind::kWindow, {GraphProcessNoise(), GraphLossScale()},
             [lag_frames](double rate_hz, EstimatorOptions* options) {
               options->graph.lag_s = lag_frames / rate_hz;
               options->graph.bones = false;
             });
  strategy.lag_frames = lag_frames;
  strategy.tuned_as = kOfflineReference;
  return strategy;
}

// Each frame by itself, and what is written in paper mode.
void AddUnfiltered(std::vector<Strategy>* table) {
  table->push_back(Filter("raw_dlt", "raw DLT", OutputKind::kRawDlt));
  table->push_back(
      Filter("robust_triangulation", "robust triangulation, each frame",
             OutputKind::kRobustTriangulation,
             {Field("loss_scale", "sigmas", {1.0, 2.0, 3.0, 4.5, 7.0, 10.0},
                    [](EstimatorOptions& o) -> double& {
                      return o.filters.robust_triangulation.loss_scale;
                    })}));
  table->push_back(
      Filter(kDefaultBaseline, "causal Gaussian (paper)", OutputKind::kGaussian,
             {Field("sigma_frames", "frames", {0.15, 0.3, 0.6, 0.8, 1.2},
                    [](EstimatorOptions& o) -> double& {
                      return o.gaussian.sigma_frames;
                    }),
              Field("wrist_sigma_frames", "frames", {0.3, 0.8, 1.2},
                    [](EstimatorOptions& o) -> double& {
                      return o.gaussian.wrist_sigma_frames;
                    })}));
}

// A few samples at once, along the signal.
void AddWindowed(std::vector<Strategy>* table) {
  table->push_back(Filter(
      "centred_gaussian", "centred Gaussian", OutputKind::kCentredGaussian,
      {Field("sigma_s", "s", {0.01, 0.02, 0.04, 0.06, 0.09, 0.14},
             [](EstimatorOptions& o) -> double& {
               return o.filters.centred_gaussian.sigma_s;
             })}));
  table->push_back(Filter(
      "hampel_median", "Hampel and moving median", OutputKind::kHampelMedian,
      {Field("median_window_s", "s", {0.04, 0.12, 0.2, 0.28, 0.44},
             [](EstimatorOptions& o) -> double& {
               return o.filters.hampel_median.median_window_s;
             }),
       Field("hampel_threshold", "sigmas", {2.0, 3.0},
             [](EstimatorOptions& o) -> double& {
               return o.filters.hampel_median.hampel_threshold;
             })}));
  table->push_back(
      Filter("one_euro", "One-Euro", OutputKind::kOneEuro,
             {Field("min_cutoff_hz", "Hz", {1.0, 2.0, 4.0, 8.0, 16.0},
                    [](EstimatorOptions& o) -> double& {
                      return o.filters.one_euro.min_cutoff_hz;
                    }),
              Field("beta_per_m", "1/m", {1.0, 3.0, 10.0, 30.0, 100.0},
                    [](EstimatorOptions& o) -> double& {
                      return o.filters.one_euro.beta_per_m;
                    })}));
}

// The whole signal at once, without delay.
void AddZeroPhase(std::vector<Strategy>* table) {
  table->push_back(
      Filter("butterworth", "Butterworth, zero phase", OutputKind::kButterworth,
             {Field("cutoff_hz", "Hz", {1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0},
                    [](EstimatorOptions& o) -> double& {
                      return o.filters.butterworth.cutoff_hz;
                    })},
             [](double, EstimatorOptions* options) {
               options->filters.butterworth.choice = CutoffChoice::kFixed;
             }));
  table->push_back(Filter(
      "butterworth_residual", "Butterworth, residual analysis",
      OutputKind::kButterworth, {}, [](double, EstimatorOptions* options) {
        options->filters.butterworth.choice = CutoffChoice::kResidualAnalysis;
      }));
  table->push_back(
      Filter("savitzky_golay", "Savitzky-Golay", OutputKind::kSavitzkyGolay,
             {Field("window_s", "s", {0.2, 0.28, 0.36, 0.52, 0.76, 1.0},
                    [](EstimatorOptions& o) -> double& {
                      return o.filters.savitzky_golay.window_s;
                    })}));
  table->push_back(Filter(
      "gcv_spline", "smoothing spline, GCV", OutputKind::kSmoothingSpline, {},
      [](double, EstimatorOptions* options) {
        options->filters.smoothing_spline.choice = SmoothnessChoice::kGcv;
      }));
}

void AddKalman(std::vector<Strategy>* table) {
  const auto motion = [](MotionModel model) {
    return [model](double, EstimatorOptions* options) {
      options->filters.kalman.motion = model;
    };
  };
  const auto kalman_noise =
      Field("process_noise_factor", "",
            {0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0},
            [](EstimatorOptions& o) -> double& {
              return o.filters.kalman.process_noise_scale;
            });
  table->push_back(Filter("kalman_cv", "Kalman, constant velocity",
                          OutputKind::kKalman, {kalman_noise},
                          motion(MotionModel::kConstantVelocity)));
  table->push_back(Filter("kalman_ca", "Kalman, constant acceleration",
                          OutputKind::kKalman, {kalman_noise},
                          motion(MotionModel::kConstantAcceleration)));
  table->push_back(Filter("rts_cv", "RTS, constant velocity", OutputKind::kRts,
                          {kalman_noise},
                          motion(MotionModel::kConstantVelocity)));
  table->push_back(Filter("rts_ca", "RTS, constant acceleration",
                          OutputKind::kRts, {kalman_noise},
                          motion(MotionModel::kConstantAcceleration)));
}

// The same on points that outliers have been kept out of.
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

// What `track` runs when nothing is said: noise and bones as the take shows
// them. Nothing to tune.
Fix Learns(Fix fix) {
  return [fix = std::move(fix)](double rate_hz, EstimatorOptions* options) {
    fix(rate_hz, options);
    options->graph.pixel_noise_from = NoiseFrom::kTake;
    options->graph.process_noise_from = NoiseFrom::kTake;
    options->graph.bone_sigma_from = NoiseFrom::kTake;
  };
}

Strategy WindowThatLearns(int lag_frames) {
  Strategy strategy = Window(lag_frames);
  strategy.name += "_take";
  strategy.title += ", noise from the take";
  strategy.parameters.clear();
  strategy.tuned_as.clear();
  strategy.fix = Learns(strategy.fix);
  return strategy;
}

void AddGraph(std::vector<Strategy>* table) {
  const auto batch = [](bool bones) -> Fix {
    return [bones](double, EstimatorOptions* options) {
      options->graph.bones = bones;
      options->graph.bone_sigma_from = NoiseFrom::kFixed;
    };
  };
  for (const int lag : {0, 3, 5, 10, 20, 30}) table->push_back(Window(lag));
  table->push_back(WindowThatLearns(10));
  table->push_back(Filter(kOfflineReference, "batch", OutputKind::kBatch,
                          {GraphProcessNoise(), GraphLossScale()},
                          batch(false)));
  table->push_back(Filter(
      "batch_bones", "batch with bones", OutputKind::kBatch,
      {GraphProcessNoise(), Field("bone_sigma_m", "m", {0.01, 0.02, 0.04},
                                  [](EstimatorOptions& o) -> double& {
                                    return o.graph.bone_sigma_m;
                                  })},
      batch(true)));
  table->push_back(Filter("batch_take", "batch, noise from the take",
                          OutputKind::kBatch, {}, Learns(batch(false))));
  table->push_back(Filter("batch_bones_take",
                          "batch with bones, noise from the take",
                          OutputKind::kBatch, {}, Learns(batch(true))));
}

// In the order of the report.
std::vector<Strategy> MakeTable() {
  std::vector<Strategy> table;
  AddUnfiltered(&table);
  AddWindowed(&table);
  AddZeroPhase(&table);
  AddKalman(&table);
  for (const char* name : {"butterworth", "rts_cv"}) {
    const auto named = [name](const Strategy& s) { return s.name == name; };
    table.push_back(
        OnRobustPoints(*std::find_if(table.begin(), table.end(), named)));
  }
  AddGraph(&table);
  return table;
}

void Apply(const Strategy& strategy, const StrategyValues& values,
           double rate_hz, EstimatorOptions* options) {
  CHECK_EQ(values.size(), strategy.parameters.size()) << strategy.name;
  if (strategy.fix) strategy.fix(rate_hz, options);
  for (size_t i = 0; i < values.size(); ++i) {
    strategy.parameters[i].set(values[i], options);
  }
}

std::string Names() {
  std::string names;
  for (const Strategy& strategy : AllStrategies()) {
    names += (names.empty() ? "" : ", ") + strategy.name;
  }
  return names;
}

}  // namespace

const std::vector<Strategy>& AllStrategies() {
  static const std::vector<Strategy> table = MakeTable();
  return table;
}

std::vector<Strategy> ChooseStrategies(const std::vector<std::string>& names) {
  if (names.empty()) return AllStrategies();
  std::vector<Strategy> chosen;
  for (const std::string& name : names) {
    const auto named = [&name](const Strategy& s) { return s.name == name; };
    const auto at =
        std::find_if(AllStrategies().begin(), AllStrategies().end(), named);
    if (at == AllStrategies().end()) {
      throw InputError("no strategy is named '" + Printable(name) +
                       "', there are " + Names());
    }
    if (std::any_of(chosen.begin(), chosen.end(), named)) {
      throw InputError("strategy '" + name + "' is named twice");
    }
    chosen.push_back(*at);
  }
  return chosen;
}

StrategyValues DefaultValues(const Strategy& strategy, double rate_hz,
                             const EstimatorOptions& options) {
  EstimatorOptions fixed = options;
  if (strategy.fix) strategy.fix(rate_hz, &fixed);
  StrategyValues values;
  for (const StrategyParameter& parameter : strategy.parameters) {
    values.push_back(parameter.get(fixed));
  }
  return values;
}

EstimatorOptions OptionsOfStrategy(const Strategy& strategy,
                                   const StrategyValues& values, double rate_hz,
                                   EstimatorOptions options) {
  Apply(strategy, values, rate_hz, &options);
  options.mode = Mode::kGraph;
  options.output = strategy.kind;
  return options;
}

EstimatorFactory MakeStrategy(const Strategy& strategy,
                              const StrategyValues& values, double rate_hz,
                              EstimatorOptions options) {
  Apply(strategy, values, rate_hz, &options);
  return MakeOutput(strategy.kind, options);
}

bool IsCausalStrategy(const Strategy& strategy, const StrategyValues& values,
                      double rate_hz, const EstimatorOptions& options) {
  EstimatorOptions own = options;
  Apply(strategy, values, rate_hz, &own);
  return IsCausal(strategy.kind, own);
}

std::vector<StrategyValues> GridOf(const Strategy& strategy) {
  std::vector<StrategyValues> grid = {{}};
  for (const StrategyParameter& parameter : strategy.parameters) {
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
  std::string text;
  for (size_t i = 0; i < values.size(); ++i) {
    char number[32];
    std::snprintf(number, sizeof(number), "%.4g", values[i]);
    text +=
        (text.empty() ? "" : ", ") + strategy.parameters[i].name + " " + number;
  }
  return text.empty() ? "-" : text;
}

}  // namespace kinegraph
