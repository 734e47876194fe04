// Parameters chosen by held-out-camera error, by the same rule for every
// strategy: what is chosen on one fold of frames is scored on the other.
#ifndef KINEGRAPH_APPS_COMPARE_TUNING_H_
#define KINEGRAPH_APPS_COMPARE_TUNING_H_

#include <string>
#include <vector>

#include "apps/common/progress.h"
#include "apps/compare/comparison.h"
#include "apps/compare/strategies.h"

namespace kinegraph {

// One point of a grid.
struct TuningPoint {
  StrategyValues values;
  // Mean of min(error, 30 px) in the frames of each fold, as that fold is
  // scored; NaN: refused.
  std::vector<double> error_px;
  double pooled_px = 0.0;  // over both
};

struct StrategyTuning {
  std::vector<TuningPoint> points;  // in the order of GridOf
  FoldValues chosen;                // for each fold, chosen on the other
  double cross_px = 0.0;            // pooled over both folds
  // cross_px with values chosen on the fold on which they are scored.
  double same_fold_px = 0.0;
  double cpu_s = 0.0;
};

// `comparison` must have two folds. Strategies tuned as another one take its
// values, which are computed even if it is not among them. A strategy without
// parameters has one point.
std::vector<StrategyTuning> TuneStrategies(
    const Comparison& comparison, const std::vector<Strategy>& strategies);

// Held-out errors of points of a strategy, over all views: the sum of
// min(error, 30 px) and the number of joints. [recording of][frames of][point],
// both by fold: a fold is scored on its own recording; what is chosen for it is
// judged in the other fold's frames, on the same recording. No weight if the
// strategy cannot process the recording with these values.
struct GridErrors {
  std::vector<std::vector<std::vector<RatioUnit>>> errors;
  double cpu_s = 0.0;
};
GridErrors ScoreGrid(const Comparison& comparison, const Strategy& strategy,
                     const std::vector<StrategyValues>& points,
                     Progress* progress = nullptr);

// Values in a file, TOML: tables [first] and [second], the folds, in each
//   frames = "300:438"
// and a table per strategy with its parameters. Reads back what it wrote.
struct ParameterFile {
  std::vector<FrameRange> folds;       // two, or none: one set of values
  std::vector<FoldValues> strategies;  // in the requested order
};
void WriteParameters(const std::vector<Strategy>& strategies,
                     const ParameterFile& parameters, const std::string& path);
// Values absent from the file are the configuration's. Throws InputError naming
// file and key.
ParameterFile ReadParameters(const std::string& path,
                             const std::vector<Strategy>& strategies,
                             double rate_hz, const EstimatorOptions& options);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMPARE_TUNING_H_
