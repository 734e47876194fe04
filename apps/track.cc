// kinegraph-track: turns 2D detections into 3D tracks.
#include <fmt/format.h>
#include <gflags/gflags.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

#include "apps/common/adapter_flag.h"
#include "apps/common/app.h"
#include "apps/common/config_folder.h"
#include "apps/common/interruption.h"
#include "apps/common/progress.h"
#include "apps/common/recording_output.h"
#include "apps/common/track_files.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/data/identity_edit.h"
#include "core/io/calibration/calibration.h"
#include "core/io/calibration/tracked_cameras.h"
#include "core/io/configuration/recording_files.h"
#include "core/io/configuration/refinement_record.h"
#include "core/io/detections/format.h"
#include "core/io/detections/source.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/input_files.h"
#include "core/io/files/side_files.h"
#include "core/io/files/text_file.h"
#include "core/io/tracks/identity_edits.h"
#include "core/skeleton/body_joints.h"
#include "solvers/session/ready_recording.h"
#include "solvers/session/recording_report.h"
#include "solvers/session/run.h"

DEFINE_string(cameras, "", "calibration file or folder");
DEFINE_string(detections, "",
              "2D detections: a file or a folder; - reads frames from standard "
              "input and writes each frame as soon as it is final");
DEFINE_string(config, "",
              "configuration (TOML); without it configs/default.toml: graph "
              "mode with a delay of 0.4 s");
DEFINE_string(mode, "", "paper or graph; overrides the key mode");
DEFINE_string(set, "", "keys to change: key=value;key=value");
DEFINE_string(frames, "", "frames to use: A:B includes A and excludes B");
DEFINE_string(without_cameras, "", "names of cameras to leave out: a,b");
DEFINE_int32(threads, 1, "threads; the result does not depend on it");
DEFINE_string(corrections, "",
              "edits of identities to apply after automatic linking (JSON "
              "Lines, in the format of NAME.identity.jsonl)");
DEFINE_string(
    out, "",
    "tracks to write: .jsonl, or the extension of another format of `convert "
    "--formats` (.csv, .npz, ...); .trc for a folder with a file per person");
DEFINE_string(markers, "ours",
              "names of the joints in formats such as TRC: ours (l_hip), "
              "pose2sim (LHip) or opensim; see `convert`");
DEFINE_bool(keys, false,
            "print the keys of a configuration and exit; with --config, as a "
            "commented configuration with its values");

DEFINE_string(axes, "",
              "world axes that become the file's X,Y,Z, such as x,-y,-z, in "
              "formats with axes of their own; see `convert`");

namespace kinegraph {
namespace {

std::string KeysText() {
  const std::vector<ConfigKey> defaults = KeysOf<RunOptions>();
  if (FLAGS_config.empty()) return KeyTables(defaults);
  const RunOptions options =
      ReadRunOptions(FindConfig(FLAGS_config), FLAGS_set, FLAGS_mode);
  return CommentedConfig(KeysOf(options), defaults) +
         SkeletonTables(options.user_skeletons);
}

std::optional<AxisMap> AxesFlag() {
  if (FLAGS_axes.empty()) return std::nullopt;
  return AxisMap::Parse(FLAGS_axes);
}

// Whether frames arrive one by one in an endless stream.
bool IsLive() { return FLAGS_detections == "-"; }

bool CanBeReadAgain() { return !IsLive() && !IsPipe(FLAGS_detections); }

// Throws unless the options permit a stream: results after a bounded lag.
void RequireLag(const RunOptions& given) {
  const RunOptions options = WithRulesOfMode(given);
  if (options.tracker.life.second_pass) {
    throw OptionError(
        "tracking.second_pass",
        "needs the whole recording, which a stream never provides");
  }
  if (ChangesCameras(options) || options.identity.link ||
      !FLAGS_corrections.empty()) {
    throw InputError(
        "--detections=-: cameras.refine, cameras.refine_clock, cameras.ground, "
        "identity.link and --corrections need the whole recording, which a "
        "stream never provides");
  }
  const OutputKind output = options.estimators.output;
  if (options.estimators.mode == Mode::kGraph &&
      output != OutputKind::kWindow && output != OutputKind::kGaussian) {
    throw OptionError("output.estimator",
                      "waits for the end of each track; a stream needs window "
                      "or gaussian");
  }
}

// Whether poses depend on frames up to the end of a person's track or of the
// recording.
bool WaitsForEnd(const RunOptions& options) {
  if (PassCount(options) > 1 || options.identity.link) return true;
  const EstimatorOptions& estimators = options.estimators;
  return estimators.mode == Mode::kGraph &&
         estimators.output != OutputKind::kWindow &&
         !IsCausal(estimators.output, estimators);
}

// ", the recording has 300 .. 600", for errors about frames that do not exist.
std::string KnownFrames(std::unique_ptr<DetectionSource> source) {
  DetectionFrame frame;
  if (!source->Next(&frame)) return "";
  const int64_t first = frame.frame;
  int64_t last = first;
  while (source->Next(&frame)) last = frame.frame;
  return fmt::format(", the recording has {} .. {}", first, last);
}

// A live stream up to the first unreadable frame, which is treated as its end,
// so that earlier frames are finished and kept.
class ReadableFrames final : public DetectionSource {
 public:
  explicit ReadableFrames(std::unique_ptr<DetectionSource> source)
      : source_(std::move(source)) {}
  const DetectionHeader& header() const override { return source_->header(); }
  BadFrames bad_frames() const override { return source_->bad_frames(); }
  bool Next(DetectionFrame* frame) override {
    try {
      return !error_.has_value() && source_->Next(frame);
    } catch (const InputError& error) {
      error_ = error;
      return false;
    }
  }
  // The error that ended the stream, if any.
  const std::optional<InputError>& error() const { return error_; }

 private:
  const std::unique_ptr<DetectionSource> source_;
  std::optional<InputError> error_;
};

// The record that an earlier run added to the cameras. Throws if it has clocks,
// which are applied to the whole recording, and the run is a stream or refines
// cameras or clocks again.
std::optional<RefinementRecord> ReadRecord(const RunOptions& options) {
  std::optional<RefinementRecord> record = ReadRefinementRecord(FLAGS_cameras);
  if (!record.has_value() || !record->has_clocks()) return record;
  if (IsLive()) {
    throw InputError(
        FLAGS_cameras, "refinement",
        "its clocks need the whole recording, which a stream never provides");
  }
  if (options.refine.any()) {
    throw InputError(FLAGS_cameras, "refinement",
                     "its clocks are already refined; start from the "
                     "original calibration, or omit cameras.refine and "
                     "cameras.refine_clock");
  }
  return record;
}

// The input of a run.
struct Recording {
  RunOptions options;
  RunRequest request;
  ReadyRecording ready;

  // Opens the detections at the first frame; may be called repeatedly, except
  // for a stream or a pipe that is not in `ready`.
  std::unique_ptr<DetectionSource> Open() const {
    if (ready.detections.has_value()) {
      return std::make_unique<MemorySource>(*ready.detections);
    }
    return OpenDetections(IsLive() ? "/dev/stdin" : FLAGS_detections,
                          ReadOptions());
  }
  DetectionReadOptions ReadOptions() const {
    DetectionReadOptions read = DetectionOptionsOf(options);
    read.any_clock = true;  // the session handles clocks that step back
    return read;
  }
};

void CheckFlags() {
  RequireFlag("cameras", FLAGS_cameras);
  RequireFlag("detections", FLAGS_detections);
  RequireFlag("out", FLAGS_out);
  if (FLAGS_threads < 1) {
    throw InputError(
        fmt::format("--threads: found {}, expected at least 1", FLAGS_threads));
  }
  CheckTrackOutput(FLAGS_out, MarkersFlag(FLAGS_markers), AxesFlag());
}

Recording ReadRecording() {
  Recording recording;
  recording.options = OptionsOfFlags(FLAGS_config, FLAGS_set, FLAGS_mode);
  if (IsLive()) {
    RequireLag(recording.options);
    EndInputOnInterruption();
  }
  RunRequest& request = recording.request;
  request.frames = ParseFrameRanges(FLAGS_frames);
  request.without_cameras = ParseList(FLAGS_without_cameras, "without_cameras");
  request.threads = FLAGS_threads;
  if (!FLAGS_corrections.empty()) {
    request.corrections = ReadIdentityEdits(FLAGS_corrections);
  }
  request.cameras = ReadCameras(FLAGS_cameras, recording.options.cameras);
  // A pipe can be read only once.
  const bool is_pipe = !IsLive() && !CanBeReadAgain();
  std::optional<DetectionSequence> piped;
  recording.ready = MakeRecordingReady(
      recording.options, request, ReadRecord(recording.options), [&] {
        DetectionSequence detections = ReadDetections(
            FLAGS_detections, DetectionOptionsOf(recording.options));
        if (is_pipe) piped = detections;
        return detections;
      });
  if (is_pipe && !piped.has_value() && PassCount(recording.options) > 1) {
    piped = ReadDetections(FLAGS_detections, recording.ReadOptions());
  }
  if (!recording.ready.detections.has_value()) {
    recording.ready.detections = std::move(piped);
  }
  request.cameras = recording.ready.cameras;
  // The report needs the match of each detection; the uncertainty of the
  // cameras needs the weight of each joint.
  request.kept_matches = recording.ready.record.has_value()
                             ? KeptMatches::kWeights
                             : KeptMatches::kDetections;
  return recording;
}

// Tracks all frames, writes them to `output` and reports on them.
RecordingReport TrackFrames(const Recording& recording, DetectionSource* source,
                            Session* session, TrackOutput* output) {
  // If poses depend on the end of a track or of the recording, the detections
  // are read again for the report instead of being kept until then.
  const bool again = WaitsForEnd(recording.options) && CanBeReadAgain();
  UsedFrames used(session->scene(), again ? SourceOpener([&recording] {
                    return recording.Open();
                  })
                                          : SourceOpener());
  RecordingReporter reporter(session->scene(), source->header().skeleton,
                             IsLive());
  reporter.set_has_clocks(recording.ready.refinement == std::nullopt &&
                          recording.ready.record.has_value() &&
                          recording.ready.record->has_clocks());
  reporter.set_empty_frames_left_out(
      CanBeReadAgain() &&
      LeavesOutEmptyFrames(FLAGS_detections, recording.options.detections));
  const Skeleton& skeleton = source->header().skeleton;
  const std::unique_ptr<CameraUncertainty> uncertainty =
      recording.ready.record.has_value()
          ? UncertaintyOf(*recording.ready.record, session->scene(), skeleton)
          : nullptr;
  session->set_frame_listener(
      [&](const DetectionFrame& frame) { used.Feed(frame); });
  const int64_t frame_count = std::max<int64_t>(0, source->frame_count());
  Progress progress("tracking", frame_count * PassCount(recording.options));
  session->set_progress(
      [&](int64_t frames_read) { progress.Set(frames_read); });
  TrackAll(source, session, [&](TrackFrame&& frame) {
    if (const DetectionFrame* seen = used.At(frame.frame)) {
      reporter.See(*seen, frame);
      if (uncertainty != nullptr) uncertainty->AddTo(*seen, &frame);
    }
    output->Write(std::move(frame));
    if (IsLive()) output->Flush();
  });
  reporter.set_scale(session->scale());
  return reporter.Report();
}

void RequireFrames(const Recording& recording, const RunSummary& summary) {
  if (summary.frames > 0) return;
  std::string asked;
  if (!FLAGS_frames.empty()) {
    asked = " in --frames=" + FLAGS_frames;
    if (CanBeReadAgain()) asked += KnownFrames(recording.Open());
  }
  throw InputError(FLAGS_detections, "", "no frame to track" + asked);
}

// Writes the files beside the tracks, each with the tracks' fingerprint
// `tracks`.
void WriteSideFiles(const Recording& recording, const Session& session,
                    const RecordingReport& report, const std::string& tracks,
                    AtomicFiles* files) {
  const auto beside = [files](const char* end) {
    return files->Aside(BesideTracks(FLAGS_out, end));
  };
  if (recording.options.identity.link || !FLAGS_corrections.empty()) {
    WriteIdentityEdits(beside(kIdentityEnd), session.identity_edits(), tracks);
  }
  if (recording.ready.changes_cameras()) {
    WriteTrackedCameras(beside(kCamerasEnd), recording.ready.cameras,
                        RefinementJson(recording.ready), tracks);
  }
  // Not empty if a bias was to be learnt; states whether it is used.
  const ViewBias bias = session.view_bias();
  if (!bias.joints.empty()) {
    WriteViewBias(beside(kBiasEnd), bias, tracks);
  }
  WriteTextFile(beside(kSummaryEnd),
                WithFingerprint(ReportJson(report, session.summary(),
                                           session.learnt_noise()),
                                tracks));
}

// Failure to read a file that was just written is not an input error.
std::string FingerprintOfOwn(const std::string& path) {
  try {
    return FingerprintOfTracks(path);
  } catch (const InputError& error) {
    throw std::runtime_error(error.what());
  }
}

// Tracks and their side files appear together or not at all. Side files that an
// earlier run wrote for this --out are removed, except those that this run has
// read.
void CommitResult(const Recording& recording, const Session& session,
                  const RecordingReport& report, TrackOutput* output) {
  output->Finish();
  AtomicFiles& files = output->files();
  for (const char* end : kSideFileEnds) {
    const std::string path = BesideTracks(FLAGS_out, end);
    if (!FingerprintIn(path).empty() && !InputFiles::Has(path)) {
      files.RemoveOld(path);
    }
  }
  WriteSideFiles(recording, session, report,
                 FingerprintOfOwn(files.Aside(output->path())), &files);
  output->Commit();
}

// Adds the skipped frames to the report.
void AddBadFrames(const BadFrames& bad, RecordingReport* report) {
  if (bad.count == 0) return;
  Finding passed;
  passed.kind = "bad_frames";
  passed.evidence = fmt::format(
      "{} {}{}", bad.count,
      bad.count == 1 ? "frame that cannot be read was skipped: "
                     : "frames that cannot be read were skipped, the last "
                       "one: ",
      bad.last);
  passed.fix =
      "without input.skip_bad_frames the first such frame ends the run";
  report->warnings.push_back(std::move(passed));
}

void SayOutcome(const Recording& recording, const Session& session,
                const std::string& path, std::FILE* said) {
  for (const std::string& line : session.linking_left_out()) {
    std::fprintf(stderr, "kinegraph-track: warning: linking left out %s\n",
                 line.c_str());
  }
  if (!session.scale().is_one()) {
    std::fprintf(
        stderr,
        "kinegraph-track: subjects measure about %.2g m; the tracker's "
        "lengths, chosen for people of %.1f m, are multiplied by %.2g "
        "(cameras.subject_m)\n",
        session.scale().size_m(), kPersonSize_m, session.scale().metres());
  }
  const RunSummary& summary = session.summary();
  const bool is_human = IsHuman(session.scene().model.skeleton);
  std::string text = fmt::format(
      "{}, {}, {} -> {}\n", Counted(summary.frames, "frame", "frames"),
      is_human ? Counted(summary.people, "person", "people")
               : Counted(summary.people, "track", "tracks"),
      Counted(summary.person_frames, "pose", "poses"), path);
  text += RefinementText(recording.ready);
  if (recording.ready.changes_cameras() && !IsStream(FLAGS_out)) {
    text += "-> " + BesideTracks(FLAGS_out, kCamerasEnd) + "\n";
  }
  const std::string troubles = DescribeTroubles(
      summary.solves,
      recording.options.estimators.graph.ledger->NotConverged());
  if (!troubles.empty()) {
    text += "solver " + summary.solver + ", " + troubles + "\n";
  }
  std::fputs(text.c_str(), said);
}

void RunTrack() {
  UseAdapterFlag();
  if (FLAGS_keys) {
    std::fputs(KeysText().c_str(), stdout);
    return;
  }
  CheckFlags();
  Recording recording = ReadRecording();
  ReadableFrames* live = nullptr;
  std::unique_ptr<DetectionSource> source = recording.Open();
  if (IsLive()) {
    auto readable = std::make_unique<ReadableFrames>(std::move(source));
    live = readable.get();
    source = std::move(readable);
  }
  recording.options.estimators.graph.ledger = std::make_shared<SolveLedger>();
  Session session(recording.options, recording.request, source->header(),
                  [&recording] { return recording.Open(); });
  if (session.scene().used_views.size() < 2) {
    std::fputs(
        "kinegraph-track: warning: a single view cannot be triangulated; no "
        "person will be found\n",
        stderr);
  }
  TrackOutput output(WithFolders(FLAGS_out), session.scene().header,
                     recording.options.output.observations,
                     NamesAfter(recording.request.corrections),
                     MarkersFlag(FLAGS_markers), session.scene().model.cameras,
                     AxesFlag());
  RecordingReport report =
      TrackFrames(recording, source.get(), &session, &output);
  AddBadFrames(source->bad_frames(), &report);
  // No other command reads a live stream: FILE stands for a recording of it.
  NameInputs(Flag("cameras", FLAGS_cameras) +
                 Flag("detections", IsLive() ? "FILE" : FLAGS_detections),
             Flag("config", FLAGS_config) + Flag("set", FLAGS_set) +
                 Flag("frames", FLAGS_frames) +
                 Flag("without_cameras", FLAGS_without_cameras),
             "", &report.warnings);
  const RunSummary& summary = session.summary();
  const std::optional<InputError> ended =
      live == nullptr ? std::nullopt : live->error();
  if (ended.has_value() && summary.frames == 0) throw *ended;
  RequireFrames(recording, summary);
  const bool has_name = !IsStream(FLAGS_out);
  if (has_name) {
    CommitResult(recording, session, report, &output);
  } else {
    output.Finish();
  }
  std::FILE* const said = SummaryStream(FLAGS_out);
  SayOutcome(recording, session, output.path(), said);
  const std::string text = has_name ? ReportText(report) : WarningsText(report);
  std::fputs(text.c_str(), said);
  if (!ended.has_value()) return;
  throw InputError(fmt::format(
      "{}; the {} kept (input.skip_bad_frames=true skips such frames)",
      ended->what(),
      Counted(summary.frames, "frame before it is", "frames before it are")));
}

}  // namespace
}  // namespace kinegraph

int main(int argc, char** argv) {
  return kinegraph::RunApp(
      argc, argv,
      {"track",
       "turns 2D detections into 3D tracks",
       "--cameras=F --detections=PATH [--config=F.toml] --out=F.jsonl",
       {"--cameras=calibration.json --detections=openpose/ --config=my.toml "
        "--out=take.jsonl",
        "--cameras=calibration.json --detections=openpose/ "
        "--config=offline.toml --out=take.jsonl"}},
      kinegraph::RunTrack);
}
