// What strategies are judged by, and what a comparison found: figures with
// their intervals.
#ifndef KINEGRAPH_APPS_COMPARE_SCORES_H_
#define KINEGRAPH_APPS_COMPARE_SCORES_H_

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "apps/compare/comparison.h"
#include "apps/compare/strategies.h"
#include "apps/compare/tuning.h"
#include "core/base/constants.h"
#include "core/evaluation/derivatives.h"
#include "core/evaluation/held_out.h"
#include "core/evaluation/motion.h"
#include "core/evaluation/mpjpe.h"
#include "core/evaluation/pcp.h"
#include "core/evaluation/statistics.h"

namespace kinegraph {

// Of one flexion against the truth's; a unit a true person in a frame.
struct AngleErrors {
  std::string name;  // "l_knee_flexion"
  std::vector<RatioSeries> squared_deg2;
};

// What a strategy is judged by. Series are laid out alike for all strategies of
// a comparison.
struct StrategyScores {
  // Why it cannot be run on this recording, in one line; nothing else then
  // counts.
  std::string refused;

  HeldOutSummary held_out;
  RatioSeries held_out_errors;  // min(error, 30 px)
  // Each scored joint: its error; negative without a prediction. The unit (in
  // held_out_errors) that it belongs to is the same for all strategies.
  std::vector<float> joint_errors_px;
  std::vector<int32_t> joint_units;
  std::vector<int64_t> unit_frames;
  // Of the joints that every strategy of the comparison predicts: AddCommon.
  RatioSeries held_out_common;
  double held_out_common_median_px = 0.0;  // of their errors; NaN without any
  std::vector<RatioSeries> held_out_by_class;    // JointClass
  std::vector<HeldOutSummary> held_out_by_view;  // without intervals
  std::vector<RatioSeries> acceleration, jerk, power;
  double bone_spread_m = 0.0;
  int64_t joints = 0;  // positions given, of those that all could have given
  int64_t joints_possible = 0;

  std::optional<PcpResult> pcp;
  std::vector<RatioSeries> mpjpe, mpjpe_bias_removed;  // empty without truth
  std::optional<DerivativeResult> derivatives;
  std::vector<AngleErrors> angles;  // empty unless asked for
  std::optional<double> lag_to_truth_s;
  std::optional<double> lag_to_batch_s;
  Consistency truth_consistency, held_out_consistency;

  StrategyRun run;
};

// Runs and scores; all strategies side by side on the comparison's threads, the
// same result for any number of them, but for the lags. `what` labels the
// progress.
std::vector<StrategyScores> ScoreStrategies(
    const Comparison& comparison, const std::vector<Strategy>& strategies,
    const std::vector<FoldValues>& values, const std::string& what = "scoring");

// Fills in held_out_common and its median, which compare strategies that leave
// different gaps.
void AddCommon(std::vector<StrategyScores*> scores);

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
  double value = kNan;                // NaN: none
  Interval interval = {};             // NaN: none
  double difference = kNan;           // to the baseline; NaN: none
  Interval difference_interval = {};  // paired
  Verdict verdict = Verdict::kNone;
};

struct StrategyResult {
  Strategy strategy;
  FoldValues values;
  StrategyScores scores;
  std::optional<StrategyTuning> tuning;
  std::vector<Measure> measures;  // the same keys in the same order for all

  bool ran() const { return scores.refused.empty(); }
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
  // The points that filters smooth (filters.points), as StrategyRun::alike.
  TrackSequence points;

  const StrategyResult& baseline() const { return strategies[baseline_idx]; }
  // Those that were not refused.
  std::vector<const StrategyResult*> Ran() const;
};

// Runs and scores the strategies with their values; delays are measured behind
// the truth (if any) and behind the batch, be it asked for or not. Throws
// InputError where the baseline cannot be run.
void Score(CompareResult* result);

// Fills in the measures and the lag sweep from the scores. Score calls it.
void AddMeasures(CompareResult* result);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMPARE_SCORES_H_
