#include "apps/common/held_out_cameras.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "apps/common/app.h"
#include "apps/common/config_folder.h"
#include "apps/common/progress.h"
#include "apps/common/track_files.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/io/calibration/calibration.h"
#include "core/io/configuration/config.h"
#include "core/io/configuration/recording_files.h"
#include "core/io/configuration/refinement_record.h"
#include "core/io/detections/source.h"
#include "core/io/detections/view_pairing.h"
#include "core/io/files/side_files.h"
#include "core/io/tracks/tracks.h"
#include "solvers/noise/bias_model.h"
#include "solvers/session/ready_recording.h"
#include "solvers/session/run.h"
#include "solvers/session/subject_gauge.h"
#include "solvers/session/subject_scale.h"

namespace kinegraph {
namespace {

// The cameras and detections with which runs are scored. Runs are tracked here
// or read from files.
struct HeldOutInput {
  HeldOutRequest request;
  RunOptions options;
  CameraRig rig;      // in the order of the file
  CameraRig cameras;  // in view order
  DetectionSequence detections;

  const std::vector<std::string>& views() const {
    return detections.header.view_names;
  }
};

HeldOutInput ReadHeldOutInput(const HeldOutRequest& request) {
  RequireFlag("cameras", request.cameras);
  RequireFlag("detections", request.detections);
  HeldOutInput input;
  input.request = request;
  if (!request.config.empty()) {
    input.options =
        ReadRunOptions(FindConfig(request.config), request.set, request.mode);
  } else if (!request.set.empty() || !request.mode.empty()) {
    throw InputError("--set, --mode: need --config");
  }
  input.rig = ReadCameras(request.cameras, input.options.cameras);
  RunRequest run_request;
  run_request.cameras = input.rig;
  input.detections = ReadClockedDetections(request.detections, request.cameras,
                                           input.options, run_request);
  UsedViews used = ChooseViews(input.views(), input.rig, input.options.cameras);
  input.cameras = std::move(used.cameras);
  KeepViews(used.views, &input.detections);
  return input;
}

// Tracks with every view except `without` (none: -1).
TrackSequence Track(const RunOptions& options, const HeldOutInput& input,
                    int without, const std::vector<FrameRange>& frames,
                    ViewBias* view_bias = nullptr) {
  RunRequest run_request;
  run_request.cameras = input.rig;
  run_request.frames = frames;
  if (without >= 0) run_request.without_cameras = {input.views()[without]};
  RunOptions in_place = options;
  // The map may also name views that are not used, which are no longer there.
  in_place.cameras.map.clear();
  for (size_t v = 0; v < input.views().size(); ++v) {
    in_place.cameras.map[input.views()[v]] = input.cameras[v].name();
  }
  // Poses are scored with the cameras of the file, so the world must not be
  // moved to the floor.
  in_place.refine.ground = GroundKind::kOff;
  return TrackSequenceOf(in_place, run_request, input.detections, view_bias);
}

// The tracks that define the people of the scored set.
TrackSequence ReadOrTrackReference(const HeldOutInput& input) {
  const HeldOutRequest& request = input.request;
  if (!request.reference.empty()) return ReadTracks(request.reference);
  if (!request.held_out_set.empty()) {
    throw InputError(
        "--held_out_set requires --reference, the tracks with the people to "
        "whom the set refers");
  }
  RequireFlag("config", request.config);
  RunOptions options =
      ReadRunOptions(FindConfig(request.config), request.set, "paper");
  options.output.observations = true;  // to know the person of each detection
  return Track(options, input, -1, request.frames);
}

// The detections to score. Errors are limited to the set's cap_px, or to
// HeldOutCapPx if `cap_by_width`.
struct ScoredSet {
  HeldOutSet set;
  bool cap_by_width = false;
};

ScoredSet ReadOrMakeSet(const HeldOutInput& input,
                        const TrackSequence& reference) {
  const HeldOutRequest& request = input.request;
  ScoredSet scored;
  if (!request.held_out_set.empty()) {
    scored.set = ReadHeldOutSet(request.held_out_set, input.views());
  } else {
    scored.set = MakeHeldOutSet(reference, 0.0);
    scored.set.pairing_gate_m *= ScaleOf(reference).metres();
    scored.cap_by_width = true;
  }
  scored.set =
      PartIn(request.folds, PartIn(request.frames, std::move(scored.set)));
  if (scored.set.detections.empty()) {
    throw InputError(
        "held-out set: no detection to score in the requested frames" +
        std::string(request.held_out_set.empty()
                        ? "; --reference, if given, must contain matches "
                          "(track it with output.observations = true)"
                        : ""));
  }
  RequireDetections(request.folds, scored.set);
  return scored;
}

// A run with one view left out, and the detector bias that it estimated.
struct HeldOutRun {
  TrackSequence tracks;
  ViewBias bias;
};

// Checks, with --runs, that there is one per view and no --folds; without
// --runs, that there is a configuration to track with.
void CheckRuns(const HeldOutInput& input) {
  const HeldOutRequest& request = input.request;
  if (request.runs.empty()) {
    RequireFlag("config", request.config);
    return;
  }
  if (!request.folds.empty()) {
    throw InputError(
        "--folds does not apply to --runs: the detector bias of existing runs "
        "was learnt when they were made");
  }
  if (request.runs.size() != input.views().size()) {
    throw InputError(fmt::format(
        "--runs: found {}, expected one for each of the {} views",
        Counted(static_cast<int64_t>(request.runs.size()), "file", "files"),
        input.views().size()));
  }
}

// Reads or tracks the run that leaves out `view`.
HeldOutRun RunOf(const HeldOutInput& input, int view) {
  HeldOutRun run;
  const HeldOutRequest& request = input.request;
  if (request.runs.empty()) {
    run.tracks = Track(input.options, input, view, request.frames, &run.bias);
    return run;
  }
  const std::string& file = request.runs[static_cast<size_t>(view)];
  run.tracks = ReadTracks(file);
  std::vector<std::string> notes;
  const std::string bias = SideFileOf(file, kBiasEnd, &notes);
  if (!bias.empty()) run.bias = ReadViewBias(bias);
  SayNotes(notes);
  return run;
}

// The bias learnt in `fold` only, applied in a run over all requested
// frames.
HeldOutRun RunWithBiasOf(const HeldOutInput& input, const FrameRange& fold,
                         int view) {
  HeldOutRun run;
  Track(input.options, input, view, {fold}, &run.bias);
  RunOptions options = input.options;
  options.estimators.graph.given_view_bias =
      std::make_shared<ViewBias>(run.bias);
  run.tracks = Track(options, input, view, input.request.frames);
  return run;
}

// Errors of the projected 3D points, and of the predicted detections:
// projections plus the bias of the detector learnt by the run.
struct HeldOutColumns {
  HeldOutScores points;
  HeldOutScores detections;
  bool any_bias = false;

  void Score(const HeldOutInput& input, const HeldOutSet& set, int view,
             const TrackSequence& reference, const HeldOutRun& run) {
    const Camera& camera = input.cameras[view];
    ScoreHeldOutCamera(set, input.detections, view, camera, reference,
                       run.tracks, &points);
    HeldOutRules rules;
    if (!run.bias.empty()) {
      any_bias = true;
      const auto predictor = std::make_shared<DetectionPredictor>(
          run.tracks.header.skeleton, run.bias);
      rules.bias_px = [predictor](const PersonPose& person, int joint_idx,
                                  const Camera& in) {
        return predictor->BiasOf(person, joint_idx, in);
      };
    }
    ScoreHeldOutCamera(set, input.detections, view, camera, reference,
                       run.tracks, &detections, rules);
  }
};

// Scores one view; with --folds, each fold with the bias learnt on the other.
void ScoreView(const HeldOutInput& input, const ScoredSet& scored, int view,
               const TrackSequence& reference, HeldOutColumns* columns) {
  const std::vector<FrameRange>& folds = input.request.folds;
  if (folds.empty()) {
    columns->Score(input, scored.set, view, reference, RunOf(input, view));
    return;
  }
  for (size_t f = 0; f < 2; ++f) {
    columns->Score(input, PartIn({folds[f]}, scored.set), view, reference,
                   RunWithBiasOf(input, folds[1 - f], view));
  }
}

EvaluationOutput DescribeColumns(const HeldOutColumns& columns,
                                 const HeldOutInput& input) {
  EvaluationOutput output = DescribeHeldOut(columns.points, input.views());
  if (!columns.any_bias) return output;
  const EvaluationOutput predicted =
      DescribeHeldOut(columns.detections, input.views());
  output.text +=
      "\nPredicting detections (the 3D point plus the detector's bias as "
      "learnt by the run):\n" +
      predicted.text;
  output.json["predicts_detections"] = predicted.json;
  return output;
}

}  // namespace

DetectionSequence ReadClockedDetections(const std::string& detections,
                                        const std::string& cameras,
                                        const RunOptions& options,
                                        const RunRequest& request) {
  DetectionSequence read =
      ReadDetections(detections, DetectionOptionsOf(options));
  const auto record = ReadRefinementRecord(cameras);
  if (!record.has_value() || !record->has_clocks()) return read;
  return WithRecordedClocks(options, request, *record, read);
}

HeldOutSet PartIn(const std::vector<FrameRange>& frames, HeldOutSet set) {
  set.detections.erase(
      std::remove_if(set.detections.begin(), set.detections.end(),
                     [&frames](const HeldOutDetection& one) {
                       return !ContainsFrame(frames, one.frame);
                     }),
      set.detections.end());
  return set;
}

void RequireDetections(const std::vector<FrameRange>& folds,
                       const HeldOutSet& set) {
  for (const FrameRange& fold : folds) {
    if (!PartIn({fold}, set).detections.empty()) continue;
    throw InputError(
        fmt::format("--folds: {}:{} has no detection of a tracked person, so "
                    "nothing can be chosen or scored there",
                    fold.begin, fold.end));
  }
}

double HeldOutCapPx(const Camera& camera, const std::string& file) {
  if (camera.width_px() > 0) return 0.1 * camera.width_px();
  throw InputError(file, "camera '" + camera.name() + "'",
                   "no image size, which bounds the held-out error "
                   "(cameras.image_size)");
}

EvaluationOutput ScoreHeldOutCameras(const HeldOutRequest& request) {
  const HeldOutInput input = ReadHeldOutInput(request);
  CheckRuns(input);
  const TrackSequence reference = ReadOrTrackReference(input);
  ScoredSet scored = ReadOrMakeSet(input, reference);
  HeldOutColumns columns;
  std::vector<double> caps_px;
  {
    const int views = static_cast<int>(input.views().size());
    Progress progress("leaving out cameras", views);
    for (int view = 0; view < views; ++view) {
      if (scored.cap_by_width) {
        scored.set.cap_px = HeldOutCapPx(input.cameras[view], request.cameras);
      }
      caps_px.push_back(scored.set.cap_px);
      ScoreView(input, scored, view, reference, &columns);
      progress.Set(view + 1);
    }
  }
  EvaluationOutput output = DescribeColumns(columns, input);
  output.json["min_confidence"] = scored.set.min_confidence;
  output.json["pairing_gate_m"] = scored.set.pairing_gate_m;
  output.json["cap_px"] = caps_px;
  if (request.runs.empty()) {
    output.json["config"] = Json::parse(EffectiveConfigJson(input.options));
  }
  return output;
}

}  // namespace kinegraph
