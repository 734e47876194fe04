// kinegraph-evaluate: tracks against a ground truth, another result, or what a
// camera saw that was left out.
#include <gflags/gflags.h>

#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/common/app.h"
#include "apps/common/config_folder.h"
#include "apps/common/evaluation_output.h"
#include "apps/common/progress.h"
#include "apps/common/summary.h"
#include "apps/common/track_output.h"
#include "core/base/error.h"
#include "core/io/calibration/calibration.h"
#include "core/io/configuration/held_out_set.h"
#include "core/io/configuration/refinement_record.h"
#include "core/io/configuration/view_bias_file.h"
#include "core/io/detections/source.h"
#include "core/io/detections/view_pairing.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/text_file.h"
#include "core/io/tracks/tracks.h"
#include "solvers/noise/bias_model.h"
#include "solvers/session/refine_take.h"
#include "solvers/session/run.h"

DEFINE_string(tracks, "", "tracks to evaluate");
DEFINE_string(ground_truth, "", "what to compare with: a file or a folder");
DEFINE_string(protocol, "",
              "shelf, campus, campus_extended, 4d_association, panoptic, "
              "mpjpe, identity, parity or held_out_camera");
DEFINE_string(head, "",
              "PCP: chu, mvpose, voxelpose, 4d or raw; empty: the protocol's");
DEFINE_string(endpoints, "", "PCP: mean or each; empty: the protocol's");
DEFINE_string(matching, "",
              "PCP: nearest or one_to_one; empty: the protocol's");
DEFINE_string(frames, "",
              "A:B,... includes A and excludes B; empty: the protocol's");
DEFINE_string(annotated, "",
              "identity: everybody or some (then a pose beside all annotated "
              "people counts neither way); empty: some for actorsGT.mat of "
              "Shelf and Campus, else everybody");
DEFINE_bool(lost, false, "PCP: list every lost part");
DEFINE_string(cameras, "", "held_out_camera: calibration file or folder");
DEFINE_string(detections, "", "held_out_camera: 2D detections");
DEFINE_string(config, "", "held_out_camera: configuration (TOML)");
DEFINE_string(mode, "", "held_out_camera: paper or graph");
DEFINE_string(set, "", "held_out_camera: keys to change: key=value;...");
DEFINE_string(held_out_set, "",
              "held_out_camera: detections to score; empty: those that the "
              "reference was made from");
DEFINE_string(reference, "",
              "held_out_camera: tracks of all cameras that name the people; "
              "empty: tracked in paper mode");
DEFINE_string(runs, "",
              "held_out_camera: tracks to score instead of tracking, made "
              "without the first view, without the second, ...");
DEFINE_string(folds, "",
              "held_out_camera: two frame ranges A:B,C:D; the detector's bias "
              "is learnt on each and scored on the other");
DEFINE_string(json, "", "file to write the result to");

namespace kinegraph {
namespace {

constexpr const char* kHeldOutCamera = "held_out_camera";

// ---- Flags

struct NamedFlag {
  const char* name;
  const std::string* value;
};

// A flag that a protocol does not use would be ignored in silence.
void RefuseFlags(const std::vector<NamedFlag>& flags) {
  for (const NamedFlag& flag : flags) {
    if (flag.value->empty()) continue;
    throw InputError("--" + std::string(flag.name) +
                     " has no meaning with --protocol=" + FLAGS_protocol);
  }
}

void RefusePcpFlags() {
  RefuseFlags({{"head", &FLAGS_head},
               {"endpoints", &FLAGS_endpoints},
               {"matching", &FLAGS_matching}});
  if (FLAGS_lost) {
    throw InputError("--lost has no meaning with --protocol=" + FLAGS_protocol);
  }
}

void RefuseHeldOutFlags() {
  RefuseFlags({{"cameras", &FLAGS_cameras},
               {"detections", &FLAGS_detections},
               {"config", &FLAGS_config},
               {"mode", &FLAGS_mode},
               {"set", &FLAGS_set},
               {"held_out_set", &FLAGS_held_out_set},
               {"reference", &FLAGS_reference},
               {"runs", &FLAGS_runs},
               {"folds", &FLAGS_folds}});
}

[[noreturn]] void FailFlag(const std::string& flag, const std::string& found,
                           const std::string& expected) {
  throw InputError("--" + flag + ": found '" + Printable(found) +
                   "', expected " + expected);
}

std::vector<FrameRange> Frames() { return ParseFrameRanges(FLAGS_frames); }

std::vector<FrameRange> Folds() {
  const std::vector<FrameRange> folds = ParseFrameRanges(FLAGS_folds);
  if (folds.size() != 2) FailFlag("folds", FLAGS_folds, "two ranges A:B,C:D");
  return folds;
}

void ApplyPcpFlags(PcpProtocol* protocol) {
  const bool campus = protocol->name.rfind("campus", 0) == 0;
  if (!FLAGS_head.empty()) {
    const auto head = HeadConversionByName(FLAGS_head, campus);
    if (!head) {
      FailFlag("head", FLAGS_head, "chu, mvpose, voxelpose, 4d or raw");
    }
    protocol->head = *head;
  }
  if (FLAGS_endpoints == ToString(EndpointRule::kMean)) {
    protocol->endpoints = EndpointRule::kMean;
  } else if (FLAGS_endpoints == ToString(EndpointRule::kEach)) {
    protocol->endpoints = EndpointRule::kEach;
  } else if (!FLAGS_endpoints.empty()) {
    FailFlag("endpoints", FLAGS_endpoints, "mean or each");
  }
  if (FLAGS_matching == ToString(PersonMatching::kNearest)) {
    protocol->matching = PersonMatching::kNearest;
  } else if (FLAGS_matching == ToString(PersonMatching::kOneToOne)) {
    protocol->matching = PersonMatching::kOneToOne;
  } else if (!FLAGS_matching.empty()) {
    FailFlag("matching", FLAGS_matching, "nearest or one_to_one");
  }
  if (!FLAGS_frames.empty()) protocol->frames = Frames();
}

// ---- Output

void WriteResult(const EvaluationOutput& output) {
  Json json = {{"protocol", FLAGS_protocol}};
  if (!FLAGS_tracks.empty()) json["tracks"] = FLAGS_tracks;
  if (!FLAGS_ground_truth.empty()) json["ground_truth"] = FLAGS_ground_truth;
  if (!FLAGS_runs.empty()) json["runs"] = ParseList(FLAGS_runs, "runs");
  json["result"] = output.json;
  AtomicFile file(WithFolders(FLAGS_json));
  file.Write(json.dump(1) + "\n");
  file.Commit();
}

void Finish(const EvaluationOutput& output) {
  if (!FLAGS_json.empty()) WriteResult(output);
  std::fputs(output.text.c_str(), SummaryStream(FLAGS_json));
}

void Append(const std::string& key, const EvaluationOutput& more,
            EvaluationOutput* output) {
  output->text += "\n" + more.text;
  output->json[key] = more.json;
}

// ---- Against a ground truth

// Tracks and what they are compared with.
struct Compared {
  TrackSequence truth;
  TrackSequence tracks;
};

Compared ReadBoth(const TrackReadOptions& options = {}) {
  RequireFlag("tracks", FLAGS_tracks);
  RequireFlag("ground_truth", FLAGS_ground_truth);
  return {ReadTracks(FLAGS_ground_truth, options),
          ReadTracks(FLAGS_tracks, options)};
}

// A wrong pair of files or of frames shall not pass for a bad score.
void RequireTruth(const Compared& compared,
                  const std::vector<FrameRange>& frames) {
  for (const TrackFrame& frame : compared.truth.frames) {
    if (!frame.people.empty() && ContainsFrame(frames, frame.frame)) return;
  }
  throw InputError(FLAGS_ground_truth, "",
                   "nobody is annotated in the frames asked for");
}

// What can be said of a motion with and without a ground truth.
void AppendMotion(const Compared& compared,
                  const std::vector<FrameRange>& frames,
                  EvaluationOutput* output) {
  Append("coverage",
         DescribeCoverage(
             EvaluateCoverage(compared.truth, compared.tracks, frames)),
         output);
  const double frame_rate_hz = compared.tracks.header.frame_rate_hz;
  if (frame_rate_hz <= 0.0) {
    output->text += "(no acceleration: the tracks do not tell a frame rate)\n";
    return;
  }
  MotionOptions options;
  options.frames = frames;
  const EvaluationOutput motion =
      DescribeMotion(EvaluateMotion(compared.tracks, frame_rate_hz, options));
  output->text += motion.text;
  output->json["motion"] = motion.json;
}

void RunPcp(PcpProtocol protocol) {
  ApplyPcpFlags(&protocol);
  TrackReadOptions options;
  if (protocol.stored_zeros_are_positions) {
    options.stored_zeros = StoredZeros::kKeep;
  }
  const Compared compared = ReadBoth(options);
  RequireTruth(compared, protocol.frames);
  EvaluationOutput output = DescribePcp(
      EvaluatePcp(compared.truth, compared.tracks, protocol), FLAGS_lost);
  AppendMotion(compared, protocol.frames, &output);
  Finish(output);
}

void RunParity() {
  const Compared compared = ReadBoth();
  ParityOptions options;
  options.frames = Frames();
  Finish(
      DescribeParity(EvaluateParity(compared.truth, compared.tracks, options),
                     options, compared.truth.header.skeleton));
}

void RunMpjpe() {
  const Compared compared = ReadBoth();
  MpjpeOptions options;
  options.frames = Frames();
  RequireTruth(compared, options.frames);
  // In the world of CMU Panoptic y points down.
  const std::string& skeleton = compared.truth.header.skeleton.name();
  if (skeleton == Panoptic19().name() || skeleton == Panoptic15().name()) {
    options.up = -Eigen::Vector3d::UnitY();
  }
  EvaluationOutput output =
      DescribeMpjpe(EvaluateMpjpe(compared.truth, compared.tracks, options));
  const EvaluationOutput consistency = DescribeConsistency(EvaluateConsistency(
      compared.truth, compared.tracks, {options.frames, options.gate_m}));
  output.text += consistency.text;
  output.json["covariances"] = consistency.json;
  AppendMotion(compared, options.frames, &output);
  Finish(output);
}

Annotated AnnotatedIn(const TrackSequence& truth) {
  if (FLAGS_annotated == "some") return Annotated::kSome;
  if (FLAGS_annotated == "everybody") return Annotated::kEverybody;
  if (!FLAGS_annotated.empty()) {
    FailFlag("annotated", FLAGS_annotated, "everybody or some");
  }
  return truth.header.mode == "tum" ? Annotated::kSome : Annotated::kEverybody;
}

void RunIdentity() {
  const Compared compared = ReadBoth();
  IdentityOptions options;
  options.frames = Frames();
  options.annotated = AnnotatedIn(compared.truth);
  RequireTruth(compared, options.frames);
  Finish(DescribeIdentity(
      EvaluateIdentity(compared.truth, compared.tracks, options)));
}

void RunPanoptic() {
  const Compared compared = ReadBoth();
  PanopticOptions options;
  options.frames = Frames();
  RequireTruth(compared, options.frames);
  EvaluationOutput output = DescribePanoptic(
      EvaluatePanoptic(compared.truth, compared.tracks, options), options);
  AppendMotion(compared, options.frames, &output);
  Finish(output);
}

// ---- Held-out cameras

// Everything that is scored with, whoever made the runs.
struct HeldOutInput {
  RunOptions options;
  CameraRig rig;      // as the file has them
  CameraRig cameras;  // in the order of the views
  DetectionSequence detections;

  const std::vector<std::string>& views() const {
    return detections.header.view_names;
  }
};

HeldOutInput ReadHeldOutInput() {
  RequireFlag("cameras", FLAGS_cameras);
  RequireFlag("detections", FLAGS_detections);
  HeldOutInput input;
  if (!FLAGS_config.empty()) {
    input.options =
        ReadRunOptions(FindConfig(FLAGS_config), FLAGS_set, FLAGS_mode);
  }
  input.rig = ReadCameras(FLAGS_cameras, input.options.cameras);
  input.detections =
      ReadDetections(FLAGS_detections, DetectionOptionsOf(input.options));
  const auto record = ReadRefinementRecord(FLAGS_cameras);
  if (record.has_value() && record->has_clocks()) {
    RunRequest request;
    request.cameras = input.rig;
    input.detections =
        WithRecordedClocks(input.options, request, *record, input.detections);
  }
  input.cameras =
      CamerasOfViews(input.views(), input.rig, input.options.cameras.map);
  return input;
}

// Tracks with every view but `without` (none: -1).
TrackSequence Track(const RunOptions& options, const HeldOutInput& input,
                    int without, const std::vector<FrameRange>& frames,
                    ViewBias* view_bias = nullptr) {
  RunRequest request;
  request.cameras = input.rig;
  request.frames = frames;
  if (without >= 0) request.without_cameras = {input.views()[without]};
  // Poses are scored in the cameras as the file has them.
  RunOptions in_place = options;
  in_place.refine.ground = GroundKind::kOff;
  return TrackSequenceOf(in_place, request, input.detections, view_bias);
}

// The tracks that name the people of the scored set.
TrackSequence ReadOrTrackReference(const HeldOutInput& input) {
  if (!FLAGS_reference.empty()) return ReadTracks(FLAGS_reference);
  if (!FLAGS_held_out_set.empty()) {
    throw InputError(
        "--reference is required with --held_out_set: the tracks whose people "
        "the set names");
  }
  RequireFlag("config", FLAGS_config);
  RunOptions options =
      ReadRunOptions(FindConfig(FLAGS_config), FLAGS_set, "paper");
  options.output.observations = true;  // whom each detection belongs to
  return Track(options, input, -1, Frames());
}

// Also the cap of each camera: that of the set, or a tenth of the image width.
struct ScoredSet {
  HeldOutSet set;
  bool cap_by_width = false;

  // The part that lies in `frames`; all where there are none.
  HeldOutSet In(const std::vector<FrameRange>& frames) const {
    HeldOutSet part = set;
    part.detections.clear();
    for (const HeldOutDetection& detection : set.detections) {
      if (ContainsFrame(frames, detection.frame)) {
        part.detections.push_back(detection);
      }
    }
    return part;
  }
};

ScoredSet ReadOrMakeSet(const HeldOutInput& input,
                        const TrackSequence& reference) {
  ScoredSet scored;
  if (!FLAGS_held_out_set.empty()) {
    scored.set = ReadHeldOutSet(FLAGS_held_out_set, input.views());
  } else {
    scored.set = MakeHeldOutSet(reference, 0.0);
    scored.cap_by_width = true;
  }
  scored.set = scored.In(Frames());
  if (!FLAGS_folds.empty()) scored.set = scored.In(Folds());
  if (scored.set.detections.empty()) {
    throw InputError(
        "held-out set: no detection to score" +
        std::string(FLAGS_held_out_set.empty()
                        ? "; does --reference hold matches (track it with "
                          "output.observations = true)?"
                        : " in the frames asked for"));
  }
  return scored;
}

double CapOf(const ScoredSet& scored, const Camera& camera) {
  if (!scored.cap_by_width) return scored.set.cap_px;
  if (camera.width_px() <= 0) {
    throw InputError(FLAGS_cameras, "camera '" + camera.name() + "'",
                     "no image size, which bounds the held-out error "
                     "(cameras.image_size)");
  }
  return 0.1 * camera.width_px();
}

// A run without a view, and what it has learnt of the detector.
struct HeldOutRun {
  TrackSequence tracks;
  ViewBias bias;
};

// The runs without each view in turn: read, or tracked.
class HeldOutRuns {
 public:
  explicit HeldOutRuns(const HeldOutInput& input)
      : input_(input), files_(ParseList(FLAGS_runs, "runs")) {
    if (files_.empty()) {
      RequireFlag("config", FLAGS_config);
      return;
    }
    if (!FLAGS_folds.empty()) {
      throw InputError(
          "--folds has no meaning with --runs: they have learnt what they "
          "have learnt");
    }
    if (files_.size() != input.views().size()) {
      throw InputError("--runs: found " + std::to_string(files_.size()) +
                       " files, expected one for each of the " +
                       std::to_string(input.views().size()) + " views");
    }
  }

  HeldOutRun Get(int view) const {
    HeldOutRun run;
    if (files_.empty()) {
      run.tracks = Track(input_.options, input_, view, Frames(), &run.bias);
      return run;
    }
    run.tracks = ReadTracks(files_[view]);
    const std::string bias = BesideResult(files_[view], ".bias.json");
    if (IsFile(bias)) run.bias = ReadViewBias(bias);
    return run;
  }

  // The bias learnt in `fold` alone, used in a run over all frames.
  HeldOutRun GetWithBiasOf(const FrameRange& fold, int view) const {
    HeldOutRun run;
    Track(input_.options, input_, view, {fold}, &run.bias);
    RunOptions options = input_.options;
    options.estimators.graph.given_view_bias =
        std::make_shared<ViewBias>(run.bias);
    run.tracks = Track(options, input_, view, Frames());
    return run;
  }

 private:
  const HeldOutInput& input_;
  std::vector<std::string> files_;
};

// Errors of the 3D points alone, and of the detections that they predict.
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

// Scores one view; with --folds each fold with what the other one taught.
void ScoreView(const HeldOutInput& input, const HeldOutRuns& runs,
               const ScoredSet& scored, int view,
               const TrackSequence& reference, HeldOutColumns* columns) {
  if (FLAGS_folds.empty()) {
    columns->Score(input, scored.set, view, reference, runs.Get(view));
    return;
  }
  const std::vector<FrameRange> folds = Folds();
  for (size_t f = 0; f < 2; ++f) {
    columns->Score(input, scored.In({folds[f]}), view, reference,
                   runs.GetWithBiasOf(folds[1 - f], view));
  }
}

EvaluationOutput DescribeColumns(const HeldOutColumns& columns,
                                 const HeldOutInput& input) {
  EvaluationOutput output = DescribeHeldOut(columns.points, input.views());
  if (!columns.any_bias) return output;
  const EvaluationOutput predicted =
      DescribeHeldOut(columns.detections, input.views());
  output.text +=
      "\nPredicting detections (the 3D point and the bias that the run has "
      "learnt of the detector):\n" +
      predicted.text;
  output.json["predicts_detections"] = predicted.json;
  return output;
}

void RunHeldOut() {
  RefuseFlags(
      {{"tracks", &FLAGS_tracks}, {"ground_truth", &FLAGS_ground_truth}});
  const HeldOutInput input = ReadHeldOutInput();
  const HeldOutRuns runs(input);
  const TrackSequence reference = ReadOrTrackReference(input);
  ScoredSet scored = ReadOrMakeSet(input, reference);
  HeldOutColumns columns;
  std::vector<double> caps_px;
  {
    const int views = static_cast<int>(input.views().size());
    Progress progress("leaving out cameras", views);
    for (int view = 0; view < views; ++view) {
      scored.set.cap_px = CapOf(scored, input.cameras[view]);
      caps_px.push_back(scored.set.cap_px);
      ScoreView(input, runs, scored, view, reference, &columns);
      progress.Set(view + 1);
    }
  }
  EvaluationOutput output = DescribeColumns(columns, input);
  output.json["min_confidence"] = scored.set.min_confidence;
  output.json["pairing_gate_m"] = scored.set.pairing_gate_m;
  output.json["cap_px"] = caps_px;
  if (FLAGS_runs.empty()) {
    output.json["config"] = Json::parse(EffectiveConfigJson(input.options));
  }
  Finish(output);
}

void RunEvaluate() {
  RequireFlag("protocol", FLAGS_protocol);
  if (FLAGS_protocol == kHeldOutCamera) {
    RefusePcpFlags();
    RefuseFlags({{"annotated", &FLAGS_annotated}});
    RunHeldOut();
    return;
  }
  RefuseHeldOutFlags();
  if (FLAGS_protocol != "identity") {
    RefuseFlags({{"annotated", &FLAGS_annotated}});
  }
  if (const auto protocol = PcpProtocolByName(FLAGS_protocol)) {
    RunPcp(*protocol);
    return;
  }
  RefusePcpFlags();
  if (FLAGS_protocol == "parity") {
    RunParity();
  } else if (FLAGS_protocol == "mpjpe") {
    RunMpjpe();
  } else if (FLAGS_protocol == "identity") {
    RunIdentity();
  } else if (FLAGS_protocol == "panoptic") {
    RunPanoptic();
  } else {
    FailFlag("protocol", FLAGS_protocol,
             "shelf, campus, campus_extended, 4d_association, panoptic, mpjpe, "
             "identity, parity or held_out_camera");
  }
}

}  // namespace
}  // namespace kinegraph

int main(int argc, char** argv) {
  return kinegraph::RunApp(
      argc, argv,
      {"evaluate", "scores tracks",
       "--protocol=NAME --tracks=F --ground_truth=PATH\n"
       "       kinegraph-evaluate --protocol=held_out_camera --cameras=F "
       "--detections=PATH --config=F"},
      kinegraph::RunEvaluate);
}
