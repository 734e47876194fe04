// Tracks a recording once, keeps ("freezes") its matches of detections to
// people, and runs every strategy on them. A constant pixel shift per camera,
// the approximate effect of a calibration error, may be subtracted from the
// detections.
#ifndef KINEGRAPH_APPS_COMPARE_COMPARISON_H_
#define KINEGRAPH_APPS_COMPARE_COMPARISON_H_

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/compare/strategies.h"
#include "core/base/frame_range.h"
#include "core/data/held_out.h"
#include "core/data/pose.h"
#include "core/evaluation/held_out.h"
#include "core/evaluation/motion.h"
#include "core/evaluation/mpjpe.h"
#include "core/evaluation/pcp.h"
#include "core/io/configuration/manifest.h"
#include "core/tracking/replay.h"
#include "solvers/session/run.h"

namespace kinegraph {

// Frozen matches prepared for every estimator: with all cameras, and without
// each camera in turn. The detections may be shifted (Shifted).
struct PreparedRecording {
  DetectionSequence detections;
  std::unique_ptr<Replay> replay;
  std::vector<ReplayedPerson> all;                   // with all cameras
  std::vector<std::vector<ReplayedPerson>> without;  // one per view
};

// The frames of a recording that are scored together, and the detections on
// which they are scored.
struct Fold {
  FrameRange frames;
  std::shared_ptr<const PreparedRecording> recording;
};

// Everything that all strategies share.
struct Comparison {
  RunOptions options;
  FrozenRun run;
  // One fold with all frames, or two: values chosen on one are scored on the
  // other.
  std::vector<Fold> folds;
  HeldOutSet set;  // in the frames of the folds
  // Limit of a held-out error, and the error of a joint without a prediction;
  // one per view.
  std::vector<double> cap_px;
  // The people that the frozen run writes in the folds' frames, with their
  // identities and matches but without positions; `set` is made from them.
  TrackSequence reference;
  std::vector<PersonFrames> people;  // of `reference`, with their frames
  std::optional<TrackSequence> truth;
  // Upright direction of `truth`, by UpOfTruth
  // (apps/common/evaluation_output.h).
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  std::optional<PcpProtocol> protocol;  // for PCP, in the folds' frames
  bool angles = false;                  // also scores flexions
  int threads = 1;

  const SceneModel& scene() const { return run.scene.model; }
  double rate_hz() const { return scene().frame_rate_hz; }
  const std::vector<std::string>& views() const { return run.scene.view_names; }
  std::vector<FrameRange> scored_frames() const;
  // Blocks of one second, but at least two frames.
  BootstrapOptions bootstrap() const;
};

// Replays the frozen matches with `detections` (the run's, possibly shifted),
// with all cameras and without each of them.
std::shared_ptr<const PreparedRecording> PrepareRecording(
    const FrozenRun& run, const RunOptions& options,
    DetectionSequence detections, int threads);

// Fills in the scored set, its people and the limits of errors from `run`;
// `folds` must not be empty. `cameras` is the path of the calibration.
// `held_out_set`, if given, restricts scoring to its detections, and its cap_px
// is the limit for every view. Throws InputError if a fold has no detection to
// score, or if the limit of a camera needs its image size and that is unknown.
Comparison MakeComparison(const std::string& cameras, RunOptions options,
                          FrozenRun run, std::vector<Fold> folds,
                          const std::optional<HeldOutSet>& held_out_set,
                          int threads);

// Values of a strategy, one set per fold.
using FoldValues = std::vector<StrategyValues>;

// A strategy's result with all cameras in the frames of the folds, each fold
// with its own values.
struct StrategyRun {
  TrackSequence tracks;  // empty after scoring
  // Positions only. A joint is marked as observed where at least two of its
  // views passed the joints filter. This does not depend on the strategy, so
  // that smoothness is compared on the same joints.
  TrackSequence alike;
  int64_t cpu_ns = 0;         // of the estimators
  int64_t person_frames = 0;  // passed to the estimators
  // From a frame until its pose is final, at most; empty if whole_recording.
  std::optional<TimeNs> delay;
  bool whole_recording = false;  // no pose was final before the end
};

// Whether one run serves both folds: the same recording with the same values.
bool SameRun(const Comparison& comparison, const FoldValues& values);

StrategyRun RunWithAll(const Comparison& comparison, const Strategy& strategy,
                       const FoldValues& values);

// Runs `work`; the text of the InputError or OptionError that it throws, empty
// if there is none.
std::string RefusalOf(const std::function<void()>& work);

// The result without one camera, in all frames.
TrackSequence RunWithout(const Comparison& comparison, const Strategy& strategy,
                         const StrategyValues& values,
                         const PreparedRecording& recording, size_t view);
// Appends the held-out errors of that camera in the frames of one fold, against
// the detections of the fold, to `scores`.
void ScoreWithout(const Comparison& comparison, const Fold& fold, size_t view,
                  const TrackSequence& tracks, HeldOutScores* scores);

// The shift of detections relative to the reprojection [px], one per view: the
// medians, of x and y separately, of detection minus projection over the joints
// in the given frames that are triangulated from three or more views.
// Alternates between triangulation with shifted detections and medians, until
// no shift changes by 0.01 px, for at most 50 rounds. Shifts equivalent to
// moving the world are unobservable, and harmless.
std::vector<Eigen::Vector2d> FitShifts(const FrozenRun& run,
                                       const RunOptions& options,
                                       const FrameRange& frames, int threads);

// Detections minus the shift of their view.
DetectionSequence Shifted(DetectionSequence detections,
                          const std::vector<Eigen::Vector2d>& shifts_px);

// Fields that are not given are empty.
struct RecordingInput {
  std::string name;  // only if there are several recordings
  std::string cameras;
  std::string detections;
  std::string config;
  std::string mode;
  std::string set;
  std::string frames;
  std::string common_set = {};  // the part of `set` that all recordings share
};

// Recordings of a manifest with `config` or, if that is empty, the manifest's
// single configuration, whose mode `mode` overrides and whose set `set`
// extends. Throws InputError, which names the manifest's `path`, unless there
// are at least two recordings and, without `config`, exactly one configuration.
std::vector<RecordingInput> RecordingsOf(const Manifest& manifest,
                                         const std::string& path,
                                         const std::string& config,
                                         const std::string& mode,
                                         const std::string& set);

// A recording with at least one frame.
struct FrozenRecording {
  std::string cameras;  // path of the calibration
  RunOptions options;
  FrozenRun run;
};

// Throws InputError, also if there is no frame, or OptionError for a
// configuration with contradictory keys.
FrozenRecording FreezeRecording(const RecordingInput& input, int threads);

// The frames of a FrozenRecording, from the first to the last one written.
FrameRange AllFrames(const FrozenRun& run);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMPARE_COMPARISON_H_
