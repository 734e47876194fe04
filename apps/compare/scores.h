// The measures by which strategies are compared, and the results with their
// intervals.
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
#include "core/evaluation/mpjpe.h"
#include "core/evaluation/pcp.h"
#include "core/evaluation/smoothing_balance.h"
#include "core/evaluation/statistics.h"

namespace kinegraph {

// Errors of one flexion angle against the truth; one unit per true person and
// frame.
struct AngleErrors {
  std::string name;  // "l_knee_flexion"
  std::vector<RatioSeries> squared_deg2;
};

// All scores of a strategy. A RatioUnit at the same index stands for the same
// frame, person or segment for all strategies of a comparison.
struct StrategyScores {
  // Why it cannot be run on this recording, in one line; the other fields are
  // then meaningless.
  std::string refused;

  HeldOutSummary held_out;
  RatioSeries held_out_errors;  // min(error, 30 px)
  // The error of each scored joint, limited to the view's cap_px and negative
  // without a prediction, and the index of its unit in held_out_errors, the
  // same for all strategies.
  std::vector<float> joint_errors_px;
  std::vector<int32_t> joint_units;
  std::vector<int64_t> unit_frames;  // the frame of each unit
  // Over the joints that every strategy of the comparison predicts: AddCommon.
  RatioSeries held_out_common;
  double held_out_common_median_px = 0.0;        // NaN without such joints
  std::vector<RatioSeries> held_out_by_class;    // JointClass
  std::vector<HeldOutSummary> held_out_by_view;  // without intervals
  std::vector<RatioSeries> acceleration, jerk, power;
  double bone_spread_m = 0.0;
  int64_t joints = 0;  // with a position, of joints_possible
  int64_t joints_possible = 0;

  // By joint of the tracks' skeleton: `balance` from the held-out cameras,
  // empty if several recordings are compared (study.h); `truth_balance` from
  // the ground truth, empty without one.
  std::vector<SmoothingBalance> balance, truth_balance;

  std::optional<PcpResult> pcp;
  std::vector<RatioSeries> mpjpe, mpjpe_bias_removed;  // empty without truth
  std::optional<DerivativeResult> derivatives;
  std::vector<AngleErrors> angles;  // empty unless requested
  std::optional<double> lag_to_truth_s;
  std::optional<double> lag_to_batch_s;
  Consistency truth_consistency, held_out_consistency;

  StrategyRun run;
};

struct BalanceBasis;  // input of the smoothing balance (scores.cc)

// Runs and scores the strategies one after another, each on all threads of the
// comparison. Lags are not filled in here but by Score(). Results do not depend
// on the number of threads. `what` labels the progress. Without `balance`, the
// smoothing balance is not computed.
std::vector<StrategyScores> ScoreStrategies(
    const Comparison& comparison, const std::vector<Strategy>& strategies,
    const std::vector<FoldValues>& values, const std::string& what,
    const BalanceBasis* balance = nullptr);

// Fills in held_out_common and its median, by which strategies with different
// gaps are compared.
void AddCommon(std::vector<StrategyScores*> scores);

// The conclusion from the interval of the difference from the baseline.
enum class Verdict {
  kNone,  // no difference: the baseline, or no interval
  kSame,  // the interval contains zero: not significant
  kLess,  // the interval is below zero
  kMore,
};
const char* ToString(Verdict verdict);
Verdict VerdictOf(const Interval& difference);

inline constexpr char kHeldOut[] = "held_out_mean_px";  // a key of Measure

// One figure of one strategy.
struct Measure {
  std::string key;    // "held_out_mean_px"
  std::string title;  // "held-out error, mean of min(error, 30 px)"
  std::string unit;
  int decimals = 2;
  bool less_is_better = true;
  double value = kNan;                // NaN: none
  Interval interval = {};             // NaN: none
  double difference = kNan;           // from the baseline; NaN: none
  Interval difference_interval = {};  // paired
  Verdict verdict = Verdict::kNone;
};

struct StrategyResult {
  Strategy strategy;
  FoldValues values;
  StrategyScores scores;
  std::optional<StrategyTuning> tuning;
  // The same keys in the same order for all strategies that ran; else empty.
  std::vector<Measure> measures;

  bool ran() const { return scores.refused.empty(); }
  const Measure* Find(const std::string& key) const;
};

// A window compared with the batch.
struct LagPoint {
  size_t result_idx = 0;
  int lag_frames = 0;
  // Distance between the two results' positions of joints that are observed
  // (seen by at least two views) in both [m].
  double median_m = 0.0, p95_m = 0.0, p99_m = 0.0;
};

struct CompareResult {
  Comparison comparison;
  std::vector<StrategyResult> strategies;
  size_t baseline_idx = 0;
  std::vector<LagPoint> lag_sweep;  // empty unless the batch and windows ran
  // Pixel shifts subtracted from the detections, [fold][view]; empty: none.
  std::vector<std::vector<Eigen::Vector2d>> shifts_px;
  // The points that filters smooth (filters.points), in the form of
  // StrategyRun::alike.
  TrackSequence points;

  const StrategyResult& baseline() const { return strategies[baseline_idx]; }
  // The strategies that were not refused.
  std::vector<const StrategyResult*> Ran() const;
};

// Runs and scores the strategies with their values. Lags are measured relative
// to the truth (if any) and to the batch, which is run even if not requested;
// if it cannot be run, there is no lag to it. Throws InputError if the baseline
// cannot be run.
void Score(CompareResult* result);

// Fills in the measures and the lag sweep from the scores. Called by Score.
void AddMeasures(CompareResult* result);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMPARE_SCORES_H_
