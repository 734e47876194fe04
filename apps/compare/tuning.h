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
  // Mean of min(error, 30 px) for each fold, run on the detections of the fold
  // and scored in its frames; NaN: the strategy could not be run.
  std::vector<double> error_px;
  double pooled_px = 0.0;  // over both folds
};

struct StrategyTuning {
  std::vector<TuningPoint> points;  // in the order of GridOf
  FoldValues chosen;                // for each fold, chosen on the other
  double cross_px = 0.0;            // error of `chosen`, over both folds
  // The same with values chosen on the fold on which they are scored.
  double same_fold_px = 0.0;
  double cpu_s = 0.0;
};

// `comparison` must have two folds. A strategy that is tuned as another one
// uses the other's values, which are computed even if the other is not among
// `strategies`. A strategy without parameters has one point.
std::vector<StrategyTuning> TuneStrategies(
    const Comparison& comparison, const std::vector<Strategy>& strategies);

// Held-out errors of points of a strategy, over all views: the sum of
// min(error, 30 px) and the number of joints; weight 0 if the strategy cannot
// process the recording with these values. errors[r][f][p]: point p, run on the
// detections of fold r, in the frames of fold f. Fold r is scored by [r][r];
// its values are chosen by [r][1 - r].
struct GridErrors {
  std::vector<std::vector<std::vector<RatioUnit>>> errors;
  double cpu_s = 0.0;
};
GridErrors ScoreGrid(const Comparison& comparison, const Strategy& strategy,
                     const std::vector<StrategyValues>& points,
                     Progress* progress = nullptr);

// A TOML file with the values of each fold: tables [first] and [second], each
// with the frames of the fold,
//   frames = "300:438"
// and one table per strategy with its parameters. ReadParameters accepts what
// WriteParameters wrote.
struct ParameterFile {
  std::vector<FrameRange> folds;  // two; none if all frames share the values
  std::vector<FoldValues> strategies;  // in the requested order
};
void WriteParameters(const std::vector<Strategy>& strategies,
                     const ParameterFile& parameters, const std::string& path);
// Values absent from the file are those of the configuration. Throws InputError
// for an unreadable file, an unknown key, an invalid value, or the frames of
// only one fold.
ParameterFile ReadParameters(const std::string& path,
                             const std::vector<Strategy>& strategies,
                             double rate_hz, const EstimatorOptions& options);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMPARE_TUNING_H_
