// Tables of the paper for which a recording is tracked repeatedly with changed
// options: the ablation, the sensitivity to parameters varied over a factor of
// four, and the runtimes by stage.
#ifndef KINEGRAPH_APPS_TABLES_VARIANTS_H_
#define KINEGRAPH_APPS_TABLES_VARIANTS_H_

#include <string>
#include <vector>

#include "apps/common/plot.h"
#include "apps/tables/dataset.h"
#include "apps/tables/pcp_tables.h"
#include "core/evaluation/identity.h"
#include "core/evaluation/pcp.h"

namespace kinegraph {

// ---- Ablation: part-aware or body-aware affinity, with or without the joints
// filter.

struct AblationCell {
  AffinityKind affinity = AffinityKind::kBody;
  bool joints_filter = false;
  PcpResult pcp;
  IdentityResult identity;   // of the scored frames
  PcpDifference difference;  // from the baseline; zero for the baseline
};

// The four combinations; the baseline (body-aware without filter) first, the
// full method last. The filter is that of the update; initialisation keeps
// its own.
std::vector<AblationCell> RunAblation(const LoadedDataset& loaded);

// The paper's bars: the difference of each of the three other combinations from
// the baseline, with the paired interval; a panel for all parts and one for the
// lower arms, each as the mean over actors.
struct AblatedRecording {
  std::string name;
  std::vector<AblationCell> cells;  // from RunAblation
};
std::vector<Plot> AblationPlots(
    const std::vector<AblatedRecording>& recordings);

// The ablation for all recordings, and the effect of the joints filter in the
// front end of Chen et al., as in the paper. Writes a figure below the folder
// `out`.
TableOutput AblationTable(const BenchmarkData& data, const std::string& out);

// ---- Sensitivity

// An entry of the paper's table of parameters, as stored in options.
struct SweptParameter {
  std::string name;  // "alpha_epi"
  std::string unit;
  // Its field, followed by further parameters of the authors' code that the
  // paper calls by the same name; these are scaled by the same factor.
  std::vector<double& (*)(TrackerOptions*)> places;
  double largest;  // largest value allowed for its key

  double ValueIn(TrackerOptions options) const {
    return places.front()(&options);
  }
  void Set(double value, TrackerOptions* options) const {
    const double factor = value / ValueIn(*options);
    for (const auto place : places) place(options) *= factor;
    places.front()(options) = value;  // exactly
  }
};

// alpha_2d, alpha_epi (in the update and at initialisation), tau, epsilon,
// lambda_a.
const std::vector<SweptParameter>& SweptParameters();

// From half to twice `value` in equal logarithmic steps, with `value` in the
// middle; clipped at `largest`.
std::vector<double> SweepValues(double value, double largest);

struct SweptValue {
  double value = 0.0;
  double mean_of_actors = 0.0;  // PCP, %
  Interval interval;
  PcpDifference difference;  // from the result with the paper's value
};

struct Sweep {
  Dataset dataset;
  std::string parameter;
  std::string unit;
  double paper_value = 0.0;
  std::vector<SweptValue> values;  // ascending
};

Sweep RunSweep(const LoadedDataset& loaded, const SweptParameter& parameter);

// One panel per parameter, one line per recording.
std::vector<Plot> SensitivityPlots(const std::vector<Sweep>& sweeps);

// Tracks every recording by its first method, with each of SweptParameters()
// varied in turn. Writes figures below the folder `out`.
TableOutput SensitivityTable(const BenchmarkData& data, const std::string& out);

// ---- Runtime

// Processor time of every method on each benchmark's first two recordings;
// methods in paper mode also without the joints filter. Detections in memory,
// one thread.
TableOutput RuntimeTable(const BenchmarkData& data);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_TABLES_VARIANTS_H_
