// kinegraph-evaluate: compares tracks with a ground truth, another result,
// markers or the detections of held-out cameras, and estimated cameras with
// true ones.
#include <gflags/gflags.h>

#include <cstdio>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/common/adapter_flag.h"
#include "apps/common/app.h"
#include "apps/common/evaluation_output.h"
#include "apps/common/ground_truth.h"
#include "apps/common/held_out_cameras.h"
#include "apps/common/table.h"
#include "apps/common/track_files.h"
#include "apps/markers/marker_study.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/evaluation/centres.h"
#include "core/evaluation/correspondence.h"
#include "core/io/calibration/calibration.h"
#include "core/io/files/atomic_file.h"
#include "core/io/text/joint_names.h"
#include "core/io/tracks/reading_notes.h"
#include "core/io/tracks/tracks.h"

DEFINE_string(tracks, "", "tracks to evaluate");
DEFINE_string(ground_truth, "",
              "ground truth or reference result: a file or a folder");
DEFINE_string(protocol, "",
              "shelf, campus, campus_extended, 4d_association, panoptic, "
              "mpjpe, identity, parity, markers, cameras or held_out_camera");
DEFINE_string(joints, "",
              "markers: which markers define each joint (TOML, "
              "docs/validate.md); empty: a known marker set, recognised by its "
              "labels");
DEFINE_bool(
    plates, false,
    "markers: compare steps with the force plates of the ground truth (C3D)");
DEFINE_string(
    person, "",
    "markers: identity of the person in the tracks; empty: the one that "
    "fits best");
DEFINE_string(
    align, "both",
    "markers: what is aligned before scoring: both, clock, world or none");
DEFINE_bool(drift, false, "markers: also estimate a clock drift");
DEFINE_string(out, "", "markers: new folder for tables, plots and the page");
DEFINE_string(head, "",
              "PCP: chu, mvpose, voxelpose, 4d or raw; empty: the protocol's");
DEFINE_string(endpoints, "", "PCP: mean or each; empty: the protocol's");
DEFINE_string(matching, "",
              "PCP: nearest or one_to_one; empty: the protocol's");
DEFINE_string(
    frames, "",
    "frames of the tracks to score: A:B,... includes A and excludes B; "
    "empty: those of the PCP protocol, otherwise all");
DEFINE_string(annotated, "",
              "identity: who is annotated: everybody, or some (poses far from "
              "all annotated people are then ignored); empty: some for "
              "actorsGT.mat of Shelf and Campus, else everybody");
DEFINE_bool(lost, false, "PCP: list every incorrect part");
DEFINE_string(cameras, "",
              "cameras, held_out_camera: calibration file or folder");
DEFINE_string(detections, "", "held_out_camera: 2D detections");
DEFINE_string(config, "", "held_out_camera: configuration (TOML)");
DEFINE_string(mode, "", "held_out_camera: paper or graph");
DEFINE_string(set, "", "held_out_camera: keys to change: key=value;...");
DEFINE_string(held_out_set, "",
              "held_out_camera: detections to score; empty: those from which "
              "the reference was made");
DEFINE_string(reference, "",
              "held_out_camera: tracks made with all cameras, which identify "
              "the people; empty: tracked in paper mode");
DEFINE_string(runs, "",
              "held_out_camera: existing tracks to score: made without the "
              "first view, without the second, ...");
DEFINE_string(folds, "",
              "held_out_camera: two frame ranges A:B,C:D; the detector's bias "
              "learnt on each is applied and scored on the other");
DEFINE_string(
    unit, "",
    "unit of tracks and ground truth whose format does not specify it "
    "(such as BVH): m, cm or mm");
DEFINE_string(json, "", "file to write the result to");

namespace kinegraph {
namespace {

constexpr const char* kHeldOutCamera = "held_out_camera";
constexpr const char* kCameras = "cameras";

// ---- Flags

// Rejects flags that a protocol does not use instead of silently ignoring them.
void RefuseFlags(const std::vector<std::string>& names) {
  const std::string given = FirstGiven(names);
  if (given.empty()) return;
  throw InputError("--" + given +
                   " does not apply to --protocol=" + FLAGS_protocol);
}

std::vector<FrameRange> Frames() { return ParseFrameRanges(FLAGS_frames); }

// Selects the alternative that the flag names; without the flag `chosen` is
// unchanged.
template <typename Way>
void ChooseBetween(const std::string& flag, const std::string& text, Way one,
                   Way other, Way* chosen) {
  if (text.empty()) return;
  const std::string names[] = {ToString(one), ToString(other)};
  if (text != names[0] && text != names[1]) {
    FailFlag(flag, text, names[0] + " or " + names[1]);
  }
  *chosen = text == names[0] ? one : other;
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
  ChooseBetween("endpoints", FLAGS_endpoints, EndpointRule::kMean,
                EndpointRule::kEach, &protocol->endpoints);
  ChooseBetween("matching", FLAGS_matching, PersonMatching::kNearest,
                PersonMatching::kOneToOne, &protocol->matching);
  if (!FLAGS_frames.empty()) protocol->frames = Frames();
}

// ---- Output

void WriteJson(const Json& json) {
  WriteTextFile(WithFolders(FLAGS_json), DumpJson(json, 1) + "\n");
}

void WriteResult(const EvaluationOutput& output) {
  Json json = {{"protocol", FLAGS_protocol}};
  if (!FLAGS_tracks.empty()) json["tracks"] = FLAGS_tracks;
  if (!FLAGS_ground_truth.empty()) json["ground_truth"] = FLAGS_ground_truth;
  if (!FLAGS_runs.empty()) json["runs"] = ParseList(FLAGS_runs, "runs");
  json["result"] = output.json;
  WriteJson(json);
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

// ---- Against markers

std::optional<TrackId> PersonFlag() {
  if (FLAGS_person.empty()) return std::nullopt;
  const auto id = ParseNumber<int64_t>(FLAGS_person);
  if (!id)
    FailFlag("person", FLAGS_person, "the number of a person in the tracks");
  return TrackId(*id);
}

void RunMarkers() {
  RequireFlag("tracks", FLAGS_tracks);
  RequireFlag("ground_truth", FLAGS_ground_truth);
  const Align align = ParseAlign(FLAGS_align);
  if (FLAGS_drift && align != Align::kBoth && align != Align::kClock) {
    throw InputError("--drift: needs --align=both or --align=clock");
  }
  const MarkerStudy study =
      RunMarkerStudy({FLAGS_tracks,
                      FLAGS_ground_truth,
                      FLAGS_joints,
                      FLAGS_unit,
                      Frames(),
                      FLAGS_plates,
                      {align, FLAGS_drift, PersonFlag()}});
  Json json = {{"protocol", FLAGS_protocol},
               {"tracks", FLAGS_tracks},
               {"ground_truth", FLAGS_ground_truth},
               {"align", FLAGS_align}};
  json.update(MarkerJson(study));
  if (!FLAGS_out.empty()) WriteMarkerFolder(study, json, FLAGS_out);
  if (!FLAGS_json.empty()) WriteJson(json);
  std::fputs(ForTerminal(MarkerMarkdown(study), kTerminalColumns,
                         FLAGS_out.empty() ? "--out=DIR" : FLAGS_out)
                 .c_str(),
             SummaryStream(FLAGS_json));
}

// ---- Against a ground truth

// Tracks and the ground truth or tracks they are compared with.
struct Compared {
  TrackSequence truth;
  TrackSequence tracks;
  std::vector<std::string> notes;  // already printed
};

// Which positions of a person are compared.
enum class Represented {
  kByJoints,
  kByJointsOrCentre,  // ReducedToCentres
};

// Checks that files and frames correspond, because a wrong pair would otherwise
// only appear as a bad score.
Compared ReadBoth(const std::vector<FrameRange>& frames,
                  const TrackReadOptions& options = {},
                  Represented represented = Represented::kByJoints) {
  RequireFlag("tracks", FLAGS_tracks);
  RequireFlag("ground_truth", FLAGS_ground_truth);
  const TrackInput input("evaluate", FLAGS_unit,
                         {FLAGS_ground_truth, FLAGS_tracks});
  Compared compared = {input.Read(FLAGS_ground_truth, options),
                       input.Read(FLAGS_tracks, options),
                       {}};
  for (TrackSequence* side : {&compared.truth, &compared.tracks}) {
    side->header.skeleton = WithOurNames(side->header.skeleton);
  }
  std::string by_centres;
  if (represented == Represented::kByJointsOrCentre) {
    if (auto centres = ReducedToCentres(compared.truth, compared.tracks)) {
      compared.truth = std::move(centres->a);
      compared.tracks = std::move(centres->b);
      by_centres = std::move(centres->note);
    }
  }
  RequireCommonJoints(compared.truth.header.skeleton, FLAGS_ground_truth,
                      compared.tracks.header.skeleton, FLAGS_tracks);
  const auto recording = [&](const std::string& path,
                             const TrackSequence& tracks) {
    return ReadRecording{path, input.OptionsFor(path, options), &tracks};
  };
  compared.notes =
      CheckGroundTruth(recording(FLAGS_ground_truth, compared.truth),
                       recording(FLAGS_tracks, compared.tracks), frames);
  if (!by_centres.empty()) compared.notes.push_back(by_centres);
  SayNotes(compared.notes, "kinegraph-evaluate: ");
  return compared;
}

void Finish(const Compared& compared, EvaluationOutput output) {
  if (!compared.notes.empty()) output.json["notes"] = compared.notes;
  Finish(output);
}

// Adds the coverage and, if the tracks have a frame rate, measures of their
// motion, which need no ground truth.
void AppendMotion(const Compared& compared,
                  const std::vector<FrameRange>& frames,
                  EvaluationOutput* output) {
  Append("coverage",
         DescribeCoverage(
             EvaluateCoverage(compared.truth, compared.tracks, frames)),
         output);
  const double frame_rate_hz = compared.tracks.header.frame_rate_hz;
  if (frame_rate_hz <= 0.0) {
    output->text += "(no acceleration: the tracks have no frame rate)\n";
    return;
  }
  const EvaluationOutput motion =
      DescribeMotion(EvaluateMotion(compared.tracks, frame_rate_hz, {frames}));
  output->text += motion.text;
  output->json["motion"] = motion.json;
}

void RunPcp(PcpProtocol protocol) {
  ApplyPcpFlags(&protocol);
  TrackReadOptions options;
  if (protocol.stored_zeros_are_positions) {
    options.stored_zeros = StoredZeros::kKeep;
  }
  const Compared compared = ReadBoth(protocol.frames, options);
  EvaluationOutput output = DescribePcp(
      EvaluatePcp(compared.truth, compared.tracks, protocol), FLAGS_lost);
  Append("joints",
         DescribePck(
             EvaluateMpjpe(compared.truth, compared.tracks, {protocol.frames})),
         &output);
  AppendMotion(compared, protocol.frames, &output);
  Finish(compared, std::move(output));
}

void RunParity() {
  ParityOptions options;
  options.frames = Frames();
  const Compared compared = ReadBoth(options.frames);
  Finish(compared, DescribeParity(
                       EvaluateParity(compared.truth, compared.tracks, options),
                       options, compared.truth.header.skeleton));
}

void RunMpjpe() {
  MpjpeOptions options;
  options.frames = Frames();
  const Compared compared = ReadBoth(options.frames);
  options.up = UpOfTruth(compared.truth, {StatedUp(FLAGS_ground_truth)});
  EvaluationOutput output =
      DescribeMpjpe(EvaluateMpjpe(compared.truth, compared.tracks, options));
  const EvaluationOutput consistency = DescribeConsistency(
      EvaluateConsistency(compared.truth, compared.tracks, options.frames));
  output.text += consistency.text;
  output.json["covariances"] = consistency.json;
  AppendMotion(compared, options.frames, &output);
  Finish(compared, std::move(output));
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
  IdentityOptions options;
  options.frames = Frames();
  const Compared compared =
      ReadBoth(options.frames, {}, Represented::kByJointsOrCentre);
  options.annotated = AnnotatedIn(compared.truth);
  Finish(compared, DescribeIdentity(EvaluateIdentity(
                       compared.truth, compared.tracks, options)));
}

void RunPanoptic() {
  PanopticOptions options;
  options.frames = Frames();
  const Compared compared = ReadBoth(options.frames);
  EvaluationOutput output = DescribePanoptic(
      EvaluatePanoptic(compared.truth, compared.tracks, options), options);
  AppendMotion(compared, options.frames, &output);
  Finish(compared, std::move(output));
}

// ---- Cameras

void RunCameras() {
  RefuseFlags({"tracks", "frames", "unit"});
  RequireFlag("cameras", FLAGS_cameras);
  RequireFlag("ground_truth", FLAGS_ground_truth);
  const CameraResult result =
      EvaluateCameras(ReadCameras(FLAGS_ground_truth), FLAGS_ground_truth,
                      ReadCameras(FLAGS_cameras), FLAGS_cameras);
  std::vector<std::string> notes;
  for (const std::string& name : result.missing) {
    notes.push_back(Printable(name) +
                    " of the ground truth was not estimated and is not scored");
  }
  SayNotes(notes, "kinegraph-evaluate: ");
  Finish(DescribeCameras(result));
}

// ---- Held-out cameras

void RunHeldOut() {
  RefuseFlags({"tracks", "ground_truth", "unit"});
  const std::vector<std::string> runs = ParseList(FLAGS_runs, "runs");
  const std::vector<FrameRange> frames = Frames();
  const std::vector<FrameRange> folds = ParseFrameRanges(FLAGS_folds);
  if (!FLAGS_folds.empty() && folds.size() != 2) {
    FailFlag("folds", FLAGS_folds, "two ranges A:B,C:D");
  }
  Finish(ScoreHeldOutCameras({FLAGS_cameras, FLAGS_detections, FLAGS_config,
                              FLAGS_set, FLAGS_mode, FLAGS_held_out_set,
                              FLAGS_reference, runs, frames, folds}));
}

// Runs the protocol and rejects flags that belong only to other protocols.
void RunEvaluate() {
  UseAdapterFlag();
  RequireFlag("protocol", FLAGS_protocol);
  const auto pcp = PcpProtocolByName(FLAGS_protocol);
  if (FLAGS_protocol != "markers") {
    RefuseFlags({"joints", "person", "out"});
    if (!FirstGiven({"plates", "drift", "align"}).empty()) {
      throw InputError(
          "--plates, --drift and --align require --protocol=markers");
    }
  }
  if (FLAGS_protocol != kHeldOutCamera) {
    if (FLAGS_protocol != kCameras) RefuseFlags({"cameras"});
    RefuseFlags({"detections", "config", "mode", "set", "held_out_set",
                 "reference", "runs", "folds"});
  }
  if (FLAGS_protocol != "identity") RefuseFlags({"annotated"});
  if (!pcp) RefuseFlags({"head", "endpoints", "matching", "lost"});
  if (pcp) return RunPcp(*pcp);
  constexpr std::pair<const char*, void (*)()> kProtocols[] = {
      {"panoptic", RunPanoptic},   {"mpjpe", RunMpjpe},
      {"identity", RunIdentity},   {"parity", RunParity},
      {"markers", RunMarkers},     {kCameras, RunCameras},
      {kHeldOutCamera, RunHeldOut}};
  for (const auto& [name, run] : kProtocols) {
    if (FLAGS_protocol == name) return run();
  }
  FailFlag("protocol", FLAGS_protocol,
           "shelf, campus, campus_extended, 4d_association, panoptic, mpjpe, "
           "identity, parity, markers, cameras or held_out_camera");
}

}  // namespace
}  // namespace kinegraph

int main(int argc, char** argv) {
  return kinegraph::RunApp(
      argc, argv,
      {"evaluate",
       "scores tracks against the truth, markers or a held-out camera",
       "--protocol=NAME --tracks=F --ground_truth=PATH\n"
       "       kinegraph-evaluate --protocol=held_out_camera --cameras=F "
       "--detections=PATH --config=F",
       {"--protocol=mpjpe --tracks=take.jsonl --ground_truth=truth.jsonl",
        "--protocol=held_out_camera --cameras=calibration.json "
        "--detections=openpose/ --config=my.toml"}},
      kinegraph::RunEvaluate);
}
