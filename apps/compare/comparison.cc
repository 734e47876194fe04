#include "apps/compare/comparison.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "apps/common/app.h"
#include "apps/common/config_folder.h"
#include "apps/common/held_out_cameras.h"
#include "core/base/error.h"
#include "core/evaluation/statistics.h"
#include "core/io/calibration/calibration.h"
#include "core/io/configuration/config.h"
#include "core/tracking/replay.h"
#include "solvers/graph/assembler.h"

namespace kinegraph {
namespace {

// The people written in each frame, with their detections. They determine the
// held-out set and the units (people and frames) over which errors are pooled.
// All joints are marked as present but have no positions.
TrackSequence WrittenPeople(const FrozenRun& run,
                            const std::vector<FrameRange>& frames) {
  TrackSequence people;
  people.header = run.scene.header;
  std::map<int64_t, TrackFrame> by_frame;
  Pose3d present(run.scene.model.skeleton.joints().size());
  for (Joint3d& joint : present) joint.status = JointStatus::kObserved;
  for (const FrozenPerson& person : run.matches.people) {
    for (const FrozenFrame& frame : person.frames) {
      if (!frame.written || frame.frame < run.first_frame) continue;
      if (!ContainsFrame(frames, frame.frame)) continue;
      TrackFrame& at = by_frame[frame.frame];
      at.frame = frame.frame;
      at.time = frame.time;
      PersonPose& written = at.people.emplace_back();
      written.id = person.id;
      written.joints = present;
      for (const FrozenDetection& detection : frame.detections) {
        ViewMatch& match = written.matches.emplace_back();
        match.view_idx = detection.view_idx;
        match.detection_idx = detection.detection_idx;
      }
    }
  }
  for (auto& [number, frame] : by_frame) {
    people.frames.push_back(std::move(frame));
  }
  return people;
}

// Keeps the detections of `set` that are also in `wanted`, and takes the
// minimum confidence from `wanted`.
void Restrict(const HeldOutSet& wanted, HeldOutSet* set) {
  std::set<std::tuple<int64_t, std::string, int>> named;
  for (const HeldOutDetection& one : wanted.detections) {
    named.emplace(one.frame, one.view_name, one.detection_idx);
  }
  set->min_confidence = wanted.min_confidence;
  set->detections.erase(
      std::remove_if(set->detections.begin(), set->detections.end(),
                     [&named](const HeldOutDetection& one) {
                       return named.count({one.frame, one.view_name,
                                           one.detection_idx}) == 0;
                     }),
      set->detections.end());
}

TrackSequence Assemble(const Comparison& comparison,
                       const PreparedRecording& recording,
                       const std::vector<ReplayedPerson>& people,
                       std::vector<ReplayOutcome> outcomes) {
  TrackSequence tracks;
  tracks.header = comparison.run.scene.header;
  tracks.frames =
      AssembleReplay(recording.replay->empty_frames(), people,
                     std::move(outcomes), comparison.run.first_frame);
  return tracks;
}

DetectorSigma SigmaOf(const GraphOptions& options) {
  return [options](JointClass joint_class, double confidence, double depth_m,
                   double focal_px) {
    return PixelSigma(options, joint_class, confidence, depth_m, focal_px);
  };
}

constexpr int kMaxRounds = 50;
constexpr double kSettledPx = 0.01;
// A point triangulated from two views fits each detection exactly along its
// epipolar line, so the residuals carry little information.
constexpr int kMinViews = 3;

// Residuals of one view, by coordinate.
struct Residuals {
  std::vector<double> x, y;
};

std::vector<Residuals> ResidualsOf(const FrozenRun& run,
                                   const std::vector<ReplayedPerson>& people,
                                   const FrameRange& frames) {
  std::vector<Residuals> views(run.scene.view_names.size());
  for (const ReplayedPerson& person : people) {
    for (const EstimatorFrame& frame : person.frames) {
      if (!frame.has_initial || !frames.Contains(frame.frame)) continue;
      for (const FreshView& view : frame.views) {
        const Camera& camera = run.scene.model.cameras[view.view_idx];
        for (size_t j = 0; j < frame.initial.size(); ++j) {
          if (frame.inlier_views[j] < kMinViews ||
              frame.initial[j].status != JointStatus::kObserved ||
              view.verdicts[j] != FilterVerdict::kKept) {
            continue;
          }
          const auto pixel = camera.Project(frame.initial[j].position_m);
          if (!pixel.has_value()) continue;
          const Eigen::Vector2d residual = view.joints[j].px - *pixel;
          views[view.view_idx].x.push_back(residual.x());
          views[view.view_idx].y.push_back(residual.y());
        }
      }
    }
  }
  return views;
}

// Copies positions only, and marks a joint as observed in the frames in which
// it was triangulated (StrategyRun::alike).
TrackSequence AlikeObserved(const TrackSequence& tracks,
                            const std::vector<Fold>& folds) {
  TrackSequence alike;
  alike.header = tracks.header;
  for (const TrackFrame& frame : tracks.frames) {
    TrackFrame& copy = alike.frames.emplace_back();
    copy.frame = frame.frame;
    copy.time = frame.time;
    for (const PersonPose& person : frame.people) {
      PersonPose& positions = copy.people.emplace_back();
      positions.id = person.id;
      positions.joints = person.joints;
    }
  }
  for (const Fold& fold : folds) {
    std::map<std::pair<int64_t, int64_t>, const EstimatorFrame*> frames;
    for (const ReplayedPerson& person : fold.recording->all) {
      for (const EstimatorFrame& frame : person.frames) {
        frames[{frame.frame, person.id.value()}] = &frame;
      }
    }
    for (TrackFrame& frame : alike.frames) {
      if (!fold.frames.Contains(frame.frame)) continue;
      for (PersonPose& person : frame.people) {
        const EstimatorFrame& given =
            *frames.at({frame.frame, person.id.value()});
        for (size_t j = 0; j < person.joints.size(); ++j) {
          Joint3d& joint = person.joints[j];
          if (!joint.present()) continue;
          const bool observed = given.has_initial && given.initial[j].status ==
                                                         JointStatus::kObserved;
          joint.status =
              observed ? JointStatus::kObserved : JointStatus::kInferred;
        }
      }
    }
  }
  return alike;
}

}  // namespace

std::vector<FrameRange> Comparison::scored_frames() const {
  std::vector<FrameRange> frames;
  for (const Fold& fold : folds) frames.push_back(fold.frames);
  return frames;
}

BootstrapOptions Comparison::bootstrap() const {
  BootstrapOptions blocks;
  blocks.block_length = std::max<int64_t>(2, std::llround(rate_hz()));
  return blocks;
}

std::shared_ptr<const PreparedRecording> PrepareRecording(
    const FrozenRun& run, const RunOptions& options,
    DetectionSequence detections, int threads) {
  auto recording = std::make_shared<PreparedRecording>();
  recording->detections = std::move(detections);
  recording->replay = std::make_unique<Replay>(
      run.scene.model, recording->detections, run.matches,
      run.scale.IntoRun(options).tracker, FeedbackOf(options));
  recording->all = recording->replay->Prepare(-1, threads);
  for (size_t view = 0; view < run.scene.view_names.size(); ++view) {
    recording->without.push_back(
        recording->replay->Prepare(static_cast<int>(view), threads));
  }
  return recording;
}

Comparison MakeComparison(const std::string& cameras, RunOptions options,
                          FrozenRun run, std::vector<Fold> folds,
                          const std::optional<HeldOutSet>& held_out_set,
                          int threads) {
  Comparison comparison;
  comparison.options = std::move(options);
  comparison.run = std::move(run);
  comparison.folds = std::move(folds);
  comparison.threads = threads;
  comparison.reference =
      WrittenPeople(comparison.run, comparison.scored_frames());
  comparison.people = PersonFramesOf(comparison.reference);
  comparison.set = MakeHeldOutSet(comparison.reference, 0.0);
  if (held_out_set.has_value()) Restrict(*held_out_set, &comparison.set);
  if (comparison.set.detections.empty()) {
    throw InputError(comparison.people.empty() || !held_out_set.has_value()
                         ? "nothing to score: no person was tracked in the "
                           "requested frames"
                         : "nothing to score: --held_out_set contains no "
                           "detection of the people tracked here");
  }
  RequireDetections(comparison.scored_frames(), comparison.set);
  for (const Camera& camera : comparison.scene().cameras) {
    comparison.cap_px.push_back(held_out_set.has_value()
                                    ? held_out_set->cap_px
                                    : HeldOutCapPx(camera, cameras));
  }
  return comparison;
}

bool SameRun(const Comparison& comparison, const FoldValues& values) {
  return comparison.folds.size() == 2 &&
         comparison.folds[0].recording == comparison.folds[1].recording &&
         values[0] == values[1];
}

StrategyRun RunWithAll(const Comparison& comparison, const Strategy& strategy,
                       const FoldValues& values) {
  StrategyRun run;
  run.tracks.header = comparison.run.scene.header;
  run.whole_recording = true;
  const bool same = SameRun(comparison, values);
  for (size_t f = 0; f < comparison.folds.size(); ++f) {
    const Fold& fold = comparison.folds[f];
    const EstimatorFactory estimator =
        MakeStrategy(strategy, values[f], comparison.rate_hz(),
                     comparison.options.estimators);
    std::vector<ReplayOutcome> outcomes =
        RunEstimators(comparison.scene(), fold.recording->all, estimator);
    for (const ReplayOutcome& outcome : outcomes) {
      run.cpu_ns += outcome.cpu_ns;
      run.person_frames += static_cast<int64_t>(outcome.finals.size());
      if (!outcome.delay.has_value()) continue;
      run.whole_recording = false;
      run.delay = std::max(run.delay.value_or(0), *outcome.delay);
    }
    if (IsCausalStrategy(strategy, values[f], comparison.rate_hz(),
                         comparison.options.estimators)) {
      // Implemented over whole segments, but usable without delay because its
      // poses do not depend on later frames.
      run.whole_recording = false;
      run.delay = 0;
    }
    TrackSequence part = Assemble(comparison, *fold.recording,
                                  fold.recording->all, std::move(outcomes));
    for (TrackFrame& frame : part.frames) {
      if (!fold.frames.Contains(frame.frame) &&
          !(same && comparison.folds[1].frames.Contains(frame.frame))) {
        continue;
      }
      run.tracks.frames.push_back(
          comparison.run.scale.IntoWorld(std::move(frame)));
    }
    if (same) break;
  }
  run.alike = AlikeObserved(run.tracks, comparison.folds);
  return run;
}

std::string RefusalOf(const std::function<void()>& work) {
  try {
    work();
  } catch (const InputError& error) {
    return error.what();
  } catch (const OptionError& error) {
    return error.what();
  }
  return "";
}

TrackSequence RunWithout(const Comparison& comparison, const Strategy& strategy,
                         const StrategyValues& values,
                         const PreparedRecording& recording, size_t view) {
  const std::vector<ReplayedPerson>& people = recording.without[view];
  return Assemble(
      comparison, recording, people,
      RunEstimators(comparison.scene(), people,
                    MakeStrategy(strategy, values, comparison.rate_hz(),
                                 comparison.options.estimators)));
}

void ScoreWithout(const Comparison& comparison, const Fold& fold, size_t view,
                  const TrackSequence& tracks, HeldOutScores* scores) {
  HeldOutSet set = PartIn({fold.frames}, comparison.set);
  set.cap_px = comparison.cap_px[view];
  HeldOutRules rules;
  rules.pairing = HeldOutRules::Pairing::kById;
  rules.sigma_px = SigmaOf(comparison.options.estimators.graph);
  ScoreHeldOutCamera(set, fold.recording->detections, static_cast<int>(view),
                     comparison.scene().cameras[view], comparison.reference,
                     tracks, scores, rules);
}

std::vector<Eigen::Vector2d> FitShifts(const FrozenRun& run,
                                       const RunOptions& options,
                                       const FrameRange& frames, int threads) {
  std::vector<Eigen::Vector2d> shifts_px(run.scene.view_names.size(),
                                         Eigen::Vector2d::Zero());
  for (int round = 0; round < kMaxRounds; ++round) {
    const DetectionSequence shifted = Shifted(run.detections, shifts_px);
    const Replay replay(run.scene.model, shifted, run.matches,
                        run.scale.IntoRun(options).tracker,
                        FeedbackOf(options));
    double moved_px = 0.0;
    const std::vector<Residuals> residuals =
        ResidualsOf(run, replay.Prepare(-1, threads), frames);
    for (size_t view = 0; view < residuals.size(); ++view) {
      if (residuals[view].x.empty()) continue;
      const Eigen::Vector2d median(Quantile(residuals[view].x, 0.5),
                                   Quantile(residuals[view].y, 0.5));
      shifts_px[view] += median;
      moved_px = std::max(moved_px, median.norm());
    }
    if (moved_px < kSettledPx) break;
  }
  return shifts_px;
}

DetectionSequence Shifted(DetectionSequence detections,
                          const std::vector<Eigen::Vector2d>& shifts_px) {
  for (DetectionFrame& frame : detections.frames) {
    for (size_t view = 0; view < frame.views.size(); ++view) {
      for (Detection& detection : frame.views[view].detections) {
        for (Keypoint& joint : detection.joints) joint.px -= shifts_px[view];
      }
    }
  }
  return detections;
}

std::vector<RecordingInput> RecordingsOf(const Manifest& manifest,
                                         const std::string& path,
                                         const std::string& config,
                                         const std::string& mode,
                                         const std::string& set) {
  if (manifest.recordings.size() < 2) {
    throw InputError(
        path, "takes",
        "found one, expected two or more: each recording is scored "
        "with the choice made on the others");
  }
  ManifestConfiguration own;
  if (!config.empty()) {
    own.config = config;
  } else if (manifest.configurations.size() == 1) {
    own = manifest.configurations.front();
  } else {
    throw InputError(path, "configurations",
                     "found " + std::to_string(manifest.configurations.size()) +
                         ", expected one (or --config)");
  }
  std::vector<RecordingInput> recordings;
  for (const ManifestRecording& recording : manifest.recordings) {
    RecordingInput& input = recordings.emplace_back();
    input.name = recording.name;
    input.cameras = recording.cameras;
    input.detections = recording.detections;
    input.config = own.config;
    input.mode = mode.empty() ? own.mode : mode;
    input.set = JoinSets(JoinSets(own.set, recording.set), set);
    input.common_set = JoinSets(own.set, set);
    input.frames = recording.frames;
  }
  return recordings;
}

FrozenRecording FreezeRecording(const RecordingInput& input, int threads) {
  FrozenRecording recording;
  recording.cameras = input.cameras;
  recording.options =
      ReadRunOptions(FindConfig(input.config), input.set, input.mode);
  RunRequest request;
  request.cameras = ReadCameras(input.cameras, recording.options.cameras);
  request.frames = ParseFrameRanges(input.frames);
  request.threads = threads;
  recording.run =
      FreezeTracking(recording.options, request,
                     ReadClockedDetections(input.detections, input.cameras,
                                           recording.options, request));
  if (recording.run.tracks.frames.empty()) {
    throw InputError(input.detections, "",
                     "has no frame in the requested range");
  }
  return recording;
}

FrameRange AllFrames(const FrozenRun& run) {
  return {run.first_frame, run.tracks.frames.back().frame + 1};
}

}  // namespace kinegraph
