// What strategies are judged by.
#ifndef KINEGRAPH_APPS_COMPARE_SCORES_H_
#define KINEGRAPH_APPS_COMPARE_SCORES_H_

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "apps/compare/comparison.h"
#include "core/evaluation/held_out.h"
#include "core/evaluation/motion.h"
#include "core/evaluation/mpjpe.h"
#include "core/evaluation/pcp.h"

namespace kinegraph {

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
  std::optional<double> lag_to_truth_s;
  std::optional<double> lag_to_batch_s;
  Consistency truth_consistency, held_out_consistency;

  StrategyRun run;
};

// Runs and scores; all strategies side by side on the comparison's threads, the
// same result for any number of them. Lags are left to AddLags.
std::vector<StrategyScores> ScoreStrategies(
    const Comparison& comparison, const std::vector<Strategy>& strategies,
    const std::vector<FoldValues>& values, const Tick& tick = nullptr);
int64_t PiecesOfScoring(const Comparison& comparison, size_t strategies);

// Fills in held_out_common and its median, which compare strategies that leave
// different gaps.
void AddCommon(std::vector<StrategyScores*> scores);

// Delays behind the truth (if any) and behind `reference`.
void AddLags(const Comparison& comparison, const TrackSequence& reference,
             StrategyScores* scores);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMPARE_SCORES_H_
