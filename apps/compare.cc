// kinegraph-compare: every smoothing strategy on the same frozen observations.
#include <fmt/format.h>
#include <gflags/gflags.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/common/adapter_flag.h"
#include "apps/common/app.h"
#include "apps/common/config_folder.h"
#include "apps/common/evaluation_output.h"
#include "apps/common/ground_truth.h"
#include "apps/common/plot.h"
#include "apps/common/track_files.h"
#include "apps/compare/comparison.h"
#include "apps/compare/cutoffs.h"
#include "apps/compare/output.h"
#include "apps/compare/scores.h"
#include "apps/compare/strategies.h"
#include "apps/compare/study.h"
#include "apps/compare/tuning.h"
#include "apps/markers/marker_study.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/data/stance.h"
#include "core/evaluation/correspondence.h"
#include "core/io/configuration/manifest.h"
#include "core/io/configuration/recording_files.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/text_file.h"
#include "core/io/text/joint_names.h"
#include "core/io/tracks/reading_notes.h"
#include "core/io/tracks/tracks.h"

DEFINE_string(cameras, "", "calibration file or folder");
DEFINE_string(detections, "", "2D detections: a file or a folder");
DEFINE_string(
    manifest, "",
    "several recordings (TOML, docs/batch.md): the strategy and, with --tune, "
    "its parameters are chosen on all but one and scored on that one, for each "
    "in turn");
DEFINE_string(config, "", "configuration (TOML)");
DEFINE_string(mode, "", "paper or graph; empty: the configuration's");
DEFINE_string(set, "", "configuration keys to change: key=value;...");
DEFINE_string(frames, "",
              "frames to use: A:B includes A and excludes B; empty: all");
DEFINE_string(ground_truth, "", "true tracks: a file or a folder");
DEFINE_string(
    protocol, "",
    "with --ground_truth: mpjpe, or shelf, campus or campus_extended, "
    "which add PCP");
DEFINE_string(markers, "",
              "optical markers, or another program's result, as ground truth: "
              "clock and world are aligned to the tracks of the run");
DEFINE_string(
    joints, "",
    "which markers define each joint (TOML, docs/validate.md); empty: "
    "a known marker set, recognised by its labels");
DEFINE_string(strategies, "", "strategies to run: a,b,...; empty: all");
DEFINE_string(baseline, kinegraph::kDefaultBaseline,
              "the strategy that all others are compared with");
DEFINE_bool(tune, false,
            "choose every strategy's parameters by held-out error; each of two "
            "folds is scored with the values chosen on the other");
DEFINE_string(folds, "",
              "two frame ranges A:B,C:D; empty: those of --parameters or, with "
              "--tune or --fit_shift, the halves of the recording with 25 "
              "unused frames between them");
DEFINE_string(parameters, "", "file of parameters as written by --tune");
DEFINE_string(held_out_set, "",
              "file with the detections to score; empty: all");
DEFINE_bool(
    fit_shift, false,
    "remove a constant pixel shift from each camera, fitted on the other fold");
DEFINE_bool(errors, false,
            "also write every scored joint's held-out error (errors.csv)");
DEFINE_bool(angles, false,
            "with a ground truth: also score joint flexion angles (degrees)");
DEFINE_bool(plots, true, "draw the plots (needs gnuplot)");
DEFINE_string(plot_strategies,
              "raw_dlt,causal_gaussian,butterworth,rts_cv,batch,batch_bones",
              "strategies shown in plots that have no room for all of them");
DEFINE_string(joint, "r_wrist", "joint whose trajectory is plotted");
DEFINE_int32(threads, 1, "threads; the result does not depend on it");
DEFINE_string(out, "", "folder for the results; must not hold files yet");

namespace kinegraph {
namespace {

// Least number of frames in each half, and of the frames between the halves,
// which belong to neither fold.
constexpr int64_t kGapFrames = 25;

void CheckCompareFlags() {
  RequireFlag("out", FLAGS_out);
  if (FLAGS_manifest.empty()) {
    RequireFlag("cameras", FLAGS_cameras);
    RequireFlag("detections", FLAGS_detections);
    RequireFlag("config", FLAGS_config);
  } else {
    // The manifest names the files, and recordings take the place of folds.
    const std::string other = FirstGiven(
        {"cameras", "detections", "frames", "ground_truth", "protocol",
         "markers", "folds", "parameters", "held_out_set", "fit_shift",
         "errors", "angles", "joint", "plot_strategies"});
    if (!other.empty()) {
      throw InputError(
          "--" + other +
          " applies to one recording and cannot be combined with --manifest");
    }
  }
  if (FLAGS_ground_truth.empty() != FLAGS_protocol.empty()) {
    throw InputError("--ground_truth and --protocol must be given together");
  }
  if (!FLAGS_markers.empty() && !FLAGS_ground_truth.empty()) {
    throw InputError("--markers and --ground_truth exclude each other");
  }
  if (FLAGS_angles && FLAGS_ground_truth.empty() && FLAGS_markers.empty()) {
    throw InputError("--angles requires --ground_truth or --markers");
  }
  if (!FLAGS_joints.empty() && FLAGS_markers.empty()) {
    throw InputError("--joints requires --markers");
  }
  if (!FLAGS_protocol.empty() && FLAGS_protocol != "mpjpe" &&
      !PcpProtocolByName(FLAGS_protocol).has_value()) {
    FailFlag("protocol", FLAGS_protocol,
             "shelf, campus, campus_extended or mpjpe");
  }
  if (FLAGS_tune && !FLAGS_parameters.empty()) {
    throw InputError("--tune and --parameters exclude each other");
  }
  if (FLAGS_threads < 1) {
    throw InputError(
        fmt::format("--threads: found {}, expected at least 1", FLAGS_threads));
  }
}

std::vector<FrameRange> Halves(const FrameRange& all) {
  const int64_t length = (all.end - all.begin - kGapFrames) / 2;
  if (length < kGapFrames) {
    throw InputError(
        fmt::format("{} too few for the two folds of --tune and --fit_shift: "
                    "at least {} are needed",
                    Counted(all.end - all.begin, "frame is", "frames are"),
                    3 * kGapFrames));
  }
  return {{all.begin, all.begin + length}, {all.end - length, all.end}};
}

std::vector<FrameRange> FoldRanges(const FrozenRun& run,
                                   const std::optional<ParameterFile>& file) {
  if (!FLAGS_folds.empty()) {
    const auto folds = ParseFrameRanges(FLAGS_folds, "folds");
    if (folds.size() != 2) {
      throw InputError(
          fmt::format("--folds: found {} ranges, expected two", folds.size()));
    }
    return folds;
  }
  if (file.has_value() && !file->folds.empty()) return file->folds;
  if (FLAGS_tune || FLAGS_fit_shift) return Halves(AllFrames(run));
  return {AllFrames(run)};
}

// The intersection of two lists of ranges; an empty `a` stands for all frames.
std::vector<FrameRange> Common(const std::vector<FrameRange>& a,
                               const std::vector<FrameRange>& b) {
  if (a.empty()) return b;
  std::vector<FrameRange> common;
  for (const FrameRange& one : a) {
    for (const FrameRange& other : b) {
      const FrameRange both = {std::max(one.begin, other.begin),
                               std::min(one.end, other.end)};
      if (both.begin < both.end) common.push_back(both);
    }
  }
  return common;
}

void ReadTruth(Comparison* comparison) {
  comparison->run.scene.model.keep_derivatives =
      !FLAGS_markers.empty() || !FLAGS_ground_truth.empty();
  UpEvidence known;
  known.of_cameras = UpOfCameras(comparison->scene().cameras);
  if (!FLAGS_markers.empty()) {
    comparison->truth =
        MarkersAsTruth(FLAGS_markers, FLAGS_joints, comparison->run.tracks);
    comparison->up = UpOfTruth(*comparison->truth, known);
    return;
  }
  if (FLAGS_ground_truth.empty()) return;
  comparison->truth = ReadTracks(FLAGS_ground_truth);
  Skeleton& skeleton = comparison->truth->header.skeleton;
  skeleton = WithOurNames(skeleton);
  known.stated = StatedUp(FLAGS_ground_truth);
  comparison->up = UpOfTruth(*comparison->truth, known);
  RequireCommonJoints(comparison->scene().skeleton, FLAGS_detections, skeleton,
                      FLAGS_ground_truth);
  SayNotes(CheckGroundTruth({FLAGS_ground_truth, {}, &*comparison->truth},
                            {"", {}, &comparison->run.tracks},
                            comparison->scored_frames()),
           "kinegraph-compare: ");
  comparison->protocol = PcpProtocolByName(FLAGS_protocol);
  if (!comparison->protocol.has_value()) return;
  comparison->protocol->frames =
      Common(comparison->protocol->frames, comparison->scored_frames());
  if (comparison->protocol->frames.empty()) {
    throw InputError("--protocol=" + FLAGS_protocol +
                     ": none of its frames is among the scored frames");
  }
}

// The requested strategies; the baseline is always included.
std::vector<Strategy> ReadStrategies() {
  std::vector<Strategy> strategies =
      ChooseStrategies(ParseList(FLAGS_strategies, "strategies"));
  const std::vector<Strategy> baseline = ChooseStrategies({FLAGS_baseline});
  if (IndexOf(strategies, FLAGS_baseline) == strategies.size()) {
    strategies.insert(strategies.begin(), baseline.front());
  }
  return strategies;
}

// Checks the strategies of --plot_strategies if it is given; those of the
// default need not be compared.
void CheckPlotted(const std::vector<Strategy>& strategies) {
  if (FirstGiven({"plot_strategies"}).empty()) return;
  for (const std::string& name :
       ParseList(FLAGS_plot_strategies, "plot_strategies")) {
    if (IndexOf(strategies, name) == strategies.size()) {
      FailFlag("plot_strategies", name, "a strategy that is compared");
    }
  }
}

// Checks --joint if it is given; the skeleton need not have the default joint.
void CheckJoint(const Skeleton& skeleton) {
  if (FirstGiven({"joint"}).empty() || skeleton.IndexOf(FLAGS_joint) >= 0) {
    return;
  }
  FailFlag("joint", FLAGS_joint,
           fmt::format("one of {}", fmt::join(skeleton.joints(), ", ")));
}

// The folds with the detections on which each is scored: unchanged, or minus
// the shift fitted on the other fold.
std::vector<Fold> PrepareFolds(const RunOptions& options, const FrozenRun& run,
                               const std::vector<FrameRange>& ranges,
                               CompareResult* result) {
  std::vector<Fold> folds;
  if (!FLAGS_fit_shift) {
    const auto recording =
        PrepareRecording(run, options, run.detections, FLAGS_threads);
    for (const FrameRange& range : ranges) folds.push_back({range, recording});
    return folds;
  }
  for (size_t fold = 0; fold < 2; ++fold) {
    result->shifts_px.push_back(
        FitShifts(run, options, ranges[1 - fold], FLAGS_threads));
    folds.push_back(
        {ranges[fold],
         PrepareRecording(run, options,
                          Shifted(run.detections, result->shifts_px.back()),
                          FLAGS_threads)});
  }
  return folds;
}

void Tune(const std::vector<Strategy>& strategies, CompareResult* result) {
  const Comparison& comparison = result->comparison;
  std::vector<StrategyTuning> tunings = TuneStrategies(comparison, strategies);
  for (size_t s = 0; s < strategies.size(); ++s) {
    result->strategies[s].values = tunings[s].chosen;
    result->strategies[s].tuning = std::move(tunings[s]);
  }
}

// Prepares the folds, the scored set and the initial values of the strategies.
CompareResult PrepareResult(FrozenRecording recording,
                            const std::vector<Strategy>& strategies) {
  const double rate_hz = recording.run.scene.model.frame_rate_hz;
  std::optional<ParameterFile> file;
  if (!FLAGS_parameters.empty()) {
    file = ReadParameters(FLAGS_parameters, strategies, rate_hz,
                          recording.options.estimators);
  }
  CompareResult result;
  const std::vector<FrameRange> ranges = FoldRanges(recording.run, file);
  std::vector<Fold> folds =
      PrepareFolds(recording.options, recording.run, ranges, &result);
  std::optional<HeldOutSet> set;
  if (!FLAGS_held_out_set.empty()) {
    set = ReadHeldOutSet(FLAGS_held_out_set, recording.run.scene.view_names);
  }
  result.comparison = MakeComparison(
      recording.cameras, std::move(recording.options), std::move(recording.run),
      std::move(folds), set, FLAGS_threads);
  ReadTruth(&result.comparison);
  result.comparison.angles = FLAGS_angles;
  result.baseline_idx = IndexOf(strategies, FLAGS_baseline);
  for (size_t s = 0; s < strategies.size(); ++s) {
    StrategyResult& one = result.strategies.emplace_back();
    one.strategy = strategies[s];
    one.values.assign(ranges.size(),
                      DefaultValues(strategies[s], rate_hz,
                                    result.comparison.options.estimators));
    if (!file.has_value()) continue;
    for (size_t fold = 0; fold < ranges.size(); ++fold) {
      const FoldValues& given = file->strategies[s];
      one.values[fold] = given[std::min(fold, given.size() - 1)];
    }
  }
  return result;
}

void WriteTunedValues(const std::vector<Strategy>& strategies,
                      const CompareResult& result, const std::string& path) {
  ParameterFile chosen;
  for (const Fold& fold : result.comparison.folds) {
    chosen.folds.push_back(fold.frames);
  }
  for (const StrategyResult& one : result.strategies) {
    chosen.strategies.push_back(one.values);
  }
  WriteParameters(strategies, chosen, path);
}

std::string PlotsText(const CompareResult& result,
                      const std::vector<ChosenCutoff>& cutoffs,
                      const std::string& folder) {
  PlotChoice choice;
  choice.strategies = ParseList(FLAGS_plot_strategies, "plot_strategies");
  choice.joint = FLAGS_joint;
  std::string text = "\n## Plots\n";
  for (const std::string& name :
       WriteComparePlots(result, cutoffs, choice, folder)) {
    text += "\n![" + name + "](" + name + ")\n";
  }
  return text;
}

void CompareOneRecording(const std::vector<Strategy>& strategies,
                         AtomicFolder* folder) {
  const RecordingInput input = {"",           FLAGS_cameras, FLAGS_detections,
                                FLAGS_config, FLAGS_mode,    FLAGS_set,
                                FLAGS_frames};
  FrozenRecording recording = FreezeRecording(input, FLAGS_threads);
  CheckJoint(recording.run.scene.model.skeleton);
  CompareResult result = PrepareResult(std::move(recording), strategies);
  if (FLAGS_tune) Tune(strategies, &result);
  Score(&result);

  WriteTextFile(folder->PathOf("compare.json"),
                DumpJson(CompareJson(result), 1) + "\n");
  WriteTextFile(folder->PathOf("compare.csv"), CompareCsv(result));
  if (FLAGS_errors) {
    WriteTextFile(folder->PathOf("errors.csv"), ErrorsCsv(result));
  }
  const std::vector<ChosenCutoff> cutoffs = ChooseCutoffs(result);
  WriteTextFile(folder->PathOf("cutoffs.csv"), CutoffsCsv(result, cutoffs));
  if (result.comparison.truth.has_value()) {
    WriteTextFile(folder->PathOf("derivatives.csv"), DerivativesCsv(result));
  }
  std::string markdown = CompareMarkdown(result, cutoffs);
  if (FLAGS_tune) {
    WriteTunedValues(strategies, result, folder->PathOf("parameters.toml"));
  }
  if (FLAGS_plots) markdown += PlotsText(result, cutoffs, folder->PathOf(""));
  WriteTextFile(folder->PathOf("compare.md"), markdown);
  // Times differ from run to run; everything else is reproducible.
  WriteTextFile(folder->PathOf("runtime.json"),
                DumpJson(RuntimeJson(result), 1) + "\n");
  WriteTextFile(folder->PathOf("recommended.toml"), RecommendedToml(result));
  folder->Commit();
  std::printf("Processor time:\n\n%s\n%s", RuntimeTable(result).c_str(),
              Digest(result, FLAGS_out).c_str());
}

void CompareManyRecordings(const std::vector<Strategy>& strategies,
                           AtomicFolder* folder) {
  StudyRequest request;
  request.recordings =
      RecordingsOf(ReadManifest(FLAGS_manifest, ShippedConfig), FLAGS_manifest,
                   FLAGS_config, FLAGS_mode, FLAGS_set);
  request.strategies = strategies;
  request.baseline_idx = IndexOf(strategies, FLAGS_baseline);
  request.tune = FLAGS_tune;
  request.threads = FLAGS_threads;
  const Study study = RunStudy(request);
  WriteTextFile(folder->PathOf("study.json"), StudyJson(study));
  WriteTextFile(folder->PathOf("study.csv"), StudyCsv(study));
  WriteTextFile(folder->PathOf("study.md"), StudyMarkdown(study));
  WriteTextFile(folder->PathOf("recommended.toml"), StudyToml(study));
  folder->Commit();
  std::fputs(StudyDigest(study, FLAGS_out).c_str(), stdout);
}

void RunCompare() {
  UseAdapterFlag();
  CheckCompareFlags();
  if (FLAGS_plots && FLAGS_manifest.empty()) RequirePlotTool();
  const std::vector<Strategy> strategies = ReadStrategies();
  CheckPlotted(strategies);
  AtomicFolder folder(WithFolders(FLAGS_out));
  if (FLAGS_manifest.empty()) {
    CompareOneRecording(strategies, &folder);
  } else {
    CompareManyRecordings(strategies, &folder);
  }
}

}  // namespace
}  // namespace kinegraph

int main(int argc, char** argv) {
  return kinegraph::RunApp(
      argc, argv,
      {"compare",
       "compares all smoothing strategies on the same observations",
       "--cameras=F --detections=PATH --config=F.toml\n"
       "       [--ground_truth=PATH --protocol=NAME] [--tune] --out=DIR\n"
       "       kinegraph-compare --manifest=TAKES.toml [--config=F.toml] "
       "[--tune] "
       "--out=DIR",
       {"--cameras=calibration.json --detections=openpose/ --config=my.toml "
        "--out=out/compare",
        "--manifest=takes.toml --tune --out=out/compare"}},
      kinegraph::RunCompare);
}
