// How much the paper's parameters matter: each swept over a factor of four.
#ifndef KINEGRAPH_APPS_TABLES_SENSITIVITY_H_
#define KINEGRAPH_APPS_TABLES_SENSITIVITY_H_

#include <functional>
#include <string>
#include <vector>

#include "apps/common/plot.h"
#include "apps/tables/benchmark.h"
#include "apps/tables/pcp_tables.h"
#include "core/evaluation/pcp.h"

namespace kinegraph {

// A parameter of the paper's table of parameters, as options hold it.
struct SweptParameter {
  std::string name;  // "alpha_epi"
  std::string unit;
  double (*get)(const TrackerOptions& options);
  void (*set)(double value, TrackerOptions* options);
  double largest;  // that its key allows
};

// alpha_2d, alpha_epi (in the update and at initialisation), tau, epsilon,
// lambda_a.
const std::vector<SweptParameter>& SweptParameters();

// From half to twice `value` in equal steps of the logarithm, `value` in the
// middle; cut at `largest`.
std::vector<double> SweepValues(double value, double largest);

struct SweptValue {
  double value = 0.0;
  double mean_of_actors = 0.0;  // PCP, %
  Interval interval;
  double difference = 0.0;  // from the paper's value, paired
  Interval difference_interval;
};

struct Sweep {
  std::string recording;
  std::string detections_note;
  std::string parameter;
  std::string unit;
  double paper_value = 0.0;
  std::vector<SweptValue> values;  // ascending
};

// Every parameter on every recording with the recording's first method.
std::vector<Sweep> RunSensitivity(const Benchmark& benchmark,
                                  const std::string& data_folder,
                                  const std::string& extra_set,
                                  const std::function<void()>& progress);
int64_t SweepCount(const Benchmark& benchmark);

// One panel a parameter, one line a recording.
std::vector<Plot> SensitivityPlots(const std::vector<Sweep>& sweeps);
TableOutput SensitivityTable(const std::string& title,
                             const std::vector<Sweep>& sweeps,
                             const std::string& figure);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_TABLES_SENSITIVITY_H_
