// What a comparison found, as figures with their intervals.
#ifndef KINEGRAPH_APPS_COMPARE_RESULTS_H_
#define KINEGRAPH_APPS_COMPARE_RESULTS_H_

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "apps/compare/comparison.h"
#include "apps/compare/scores.h"
#include "apps/compare/strategies.h"
#include "apps/compare/tuning.h"
#include "core/evaluation/bootstrap.h"

namespace kinegraph {

// What the interval of the difference to the baseline says.
enum class Verdict {
  kNone,  // there is no difference to speak of: the baseline, no interval
  kSame,  // the interval holds zero: not told apart
  kLess,  // all of it below zero
  kMore,
};
const char* ToString(Verdict verdict);
Verdict VerdictOf(const Interval& difference);

inline constexpr char kHeldOut[] = "held_out_mean_px";  // a key of Measure

// One figure of one strategy.
struct Measure {
  std::string key;    // "held_out_mean_px"
  std::string title;  // "held-out error, mean"
  std::string unit;
  int decimals = 2;
  bool less_is_better = true;
  double value = 0.0;            // NaN: none
  Interval interval;             // NaN: none
  double difference = 0.0;       // to the baseline; NaN: none
  Interval difference_interval;  // paired
  Verdict verdict = Verdict::kNone;
};

struct StrategyResult {
  Strategy strategy;
  FoldValues values;
  StrategyScores scores;
  std::optional<StrategyTuning> tuning;
  std::vector<Measure> measures;  // the same keys in the same order for all

  const Measure* Find(const std::string& key) const;
};

// A window against the batch.
struct LagPoint {
  size_t result_idx = 0;
  int lag_frames = 0;
  // Distance of the joints that two views saw [m].
  double median_m = 0.0, p95_m = 0.0, p99_m = 0.0;
};

struct CompareResult {
  Comparison comparison;
  std::vector<StrategyResult> strategies;
  size_t baseline_idx = 0;
  std::vector<LagPoint> lag_sweep;  // empty without a batch
  // By fold, those that its detections were freed of; empty: none were.
  std::vector<std::vector<Eigen::Vector2d>> shifts_px;

  const StrategyResult& baseline() const { return strategies[baseline_idx]; }
};

// Fills in the measures and the lag sweep.
void AddMeasures(CompareResult* result);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMPARE_RESULTS_H_
