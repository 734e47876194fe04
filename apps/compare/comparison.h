// Strategies run on the same frozen matches, and what they are judged by.
#ifndef KINEGRAPH_APPS_COMPARE_COMPARISON_H_
#define KINEGRAPH_APPS_COMPARE_COMPARISON_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "apps/common/progress.h"
#include "apps/compare/strategies.h"
#include "core/base/frame_range.h"
#include "core/data/held_out.h"
#include "core/data/pose.h"
#include "core/evaluation/consistency.h"
#include "core/evaluation/held_out.h"
#include "core/evaluation/pcp.h"
#include "core/evaluation/smoothness.h"
#include "core/io/configuration/checkpoint.h"
#include "core/tracking/replay.h"
#include "solvers/session/run.h"

namespace kinegraph {

// Frozen matches ready for every estimator: with all cameras, and without each
// camera in turn. Its detections may be shifted ones.
struct PreparedTake {
  DetectionSequence detections;
  std::unique_ptr<Replay> replay;
  std::vector<ReplayedPerson> all;                   // with all cameras
  std::vector<std::vector<ReplayedPerson>> without;  // one a view
};

// A part of the take: the frames that are scored, and on what.
struct Fold {
  FrameRange frames;
  std::shared_ptr<const PreparedTake> take;
};

// Everything that all strategies share.
struct Comparison {
  RunOptions options;
  FrozenRun run;
  // One with all frames, or two: what is chosen on one is scored on the other.
  std::vector<Fold> folds;
  HeldOutSet set;              // in the frames of the folds
  std::vector<double> cap_px;  // one a view
  TrackSequence reference;     // the people of the set, by the run's identities
  std::vector<PersonFrames> people;  // that are written, in the folds' frames
  std::optional<TrackSequence> truth;
  std::optional<PcpProtocol> protocol;  // of PCP; frames those of the folds
  int threads = 1;
  // Where finished pieces are kept, and the fingerprint of all that they depend
  // on but strategy, values and view (PieceContent). Null: nothing is kept.
  Checkpoint* checkpoint = nullptr;
  std::string content;

  const SceneModel& scene() const { return run.scene.model; }
  double rate_hz() const { return scene().frame_rate_hz; }
  const std::vector<std::string>& views() const { return run.scene.view_names; }
  std::vector<FrameRange> scored_frames() const;
  // Blocks of one second.
  BootstrapOptions bootstrap() const;
};

// Frozen matches with the detections given (those of the run, or shifted ones),
// replayed with and without cameras.
std::shared_ptr<const PreparedTake> PrepareTake(const FrozenRun& run,
                                                const RunOptions& options,
                                                DetectionSequence detections,
                                                int threads);

// Fills in the folds' frames, the scored set and the rest from `run`. No fold:
// one with all frames. `held_out_set`, if given, restricts what is scored to
// its detections. Throws InputError when nothing is left to score.
Comparison MakeComparison(RunOptions options, FrozenRun run,
                          std::vector<Fold> folds,
                          const std::optional<HeldOutSet>& held_out_set,
                          int threads);

// Values of a strategy, one set a fold.
using FoldValues = std::vector<StrategyValues>;

// A strategy's answer with all cameras, in the frames of the folds, with the
// values of each fold.
struct StrategyRun {
  TrackSequence tracks;  // empty once it is scored
  // Its positions. A joint is observed where two views of the frame passed the
  // joints filter: alike for all strategies, so that smoothness is judged on
  // the same joints.
  TrackSequence alike;
  int64_t cpu_ns = 0;
  int64_t person_frames = 0;  // that the estimators were given
  std::optional<TimeNs> delay;
  bool whole_take = false;  // nobody's pose was final before the end
};

StrategyRun RunWithAll(const Comparison& comparison, const Strategy& strategy,
                       const FoldValues& values);

// The answer without one camera, in all frames.
TrackSequence RunWithout(const Comparison& comparison, const Strategy& strategy,
                         const StrategyValues& values, const PreparedTake& take,
                         size_t view);
// Held-out errors of that camera in the frames of one fold, against the
// detections of the fold; appended to `scores`.
void ScoreWithout(const Comparison& comparison, const Fold& fold, size_t view,
                  const TrackSequence& tracks, HeldOutScores* scores);

// What a strategy is judged by. Series are laid out alike for all strategies of
// a comparison.
struct StrategyScores {
  // Why it cannot be run on this take, in one line; nothing else then counts.
  std::string refused;

  HeldOutSummary held_out;
  RatioSeries held_out_errors;  // min(error, 30 px)
  // Each scored joint: its error; negative without a prediction. The unit (in
  // held_out_errors) that it belongs to is the same for all strategies.
  std::vector<float> joint_errors_px;
  std::vector<int32_t> joint_units;
  // Of the joints that every strategy of the comparison predicts: AddCommon.
  RatioSeries held_out_common;
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

// Called after each piece of work, by any thread.
using Tick = std::function<void()>;

// Runs and scores; all strategies side by side on the comparison's threads, the
// same result for any number of them. Lags are left to AddLags.
std::vector<StrategyScores> ScoreStrategies(
    const Comparison& comparison, const std::vector<Strategy>& strategies,
    const std::vector<FoldValues>& values, const Tick& tick = nullptr);
int64_t PiecesOfScoring(const Comparison& comparison, size_t strategies);

// Fills in held_out_common, which compares strategies that leave different
// gaps.
void AddCommon(std::vector<StrategyScores*> scores);

// Delays behind the truth (if any) and behind `reference`.
void AddLags(const Comparison& comparison, const TrackSequence& reference,
             StrategyScores* scores);

// A progress bar that several threads may move.
class SharedProgress {
 public:
  SharedProgress(std::string label, int64_t total)
      : progress_(std::move(label), total) {}
  void Advance() {
    const std::lock_guard<std::mutex> lock(mutex_);
    progress_.Advance();
  }

 private:
  std::mutex mutex_;
  Progress progress_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMPARE_COMPARISON_H_
