// kinegraph-demo: tracks a synthetic scene in every mode and scores the results
// against its truth.
#include <gflags/gflags.h>

#include <cstdint>
#include <cstdio>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "apps/common/app.h"
#include "apps/common/config_folder.h"
#include "apps/common/evaluation_output.h"
#include "apps/common/progress.h"
#include "apps/common/synthesis.h"
#include "apps/common/table.h"
#include "apps/report/page.h"
#include "apps/report/page_data.h"
#include "core/base/text.h"
#include "core/evaluation/identity.h"
#include "core/evaluation/motion.h"
#include "core/evaluation/mpjpe.h"
#include "core/evaluation/parity.h"
#include "core/io/files/atomic_file.h"
#include "core/io/tracks/writer.h"
#include "solvers/session/run.h"

DEFINE_string(out, "out/demo", "folder for all files; created if missing");
DEFINE_string(config, "",
              "scene and noise (TOML); empty: configs/synthetic/demo.toml");
DEFINE_string(set, "", "keys of the scene to change: key=value;key=value");

namespace kinegraph {
namespace {

constexpr double kMmPerM = 1000.0;

// One way of tracking.
struct Mode {
  const char* title;
  const char* config;  // in configs/
  const char* file;    // the tracks
};

constexpr Mode kModes[] = {
    {"paper", "synthetic/track_paper.toml", "tracks_paper.jsonl"},
    {"graph, window", "synthetic/track_window.toml", "tracks_window.jsonl"},
    {"graph, batch, bones", "synthetic/track_batch.toml", "tracks_batch.jsonl"},
};

TrackSequence Track(const Mode& mode, const SyntheticRecording& recording) {
  // With matches and weights, which the page displays.
  const RunOptions options = ReadRunOptions(ProjectConfig(mode.config),
                                            "output.observations=true", "");
  RunRequest request;
  request.cameras = recording.scene.cameras;
  Progress progress(
      std::string("tracking: ") + mode.title,
      PassCount(options) *
          static_cast<int64_t>(recording.detections.frames.size()));
  return TrackSequenceOf(
      options, request, recording.detections, nullptr,
      [&progress](int64_t frames_read) { progress.Set(frames_read); });
}

// ---- Scores

struct Scores {
  MpjpeResult error;
  ParityResult joints;  // near: 50 mm, very near: 25 mm
  Share covered;
  IdentityResult identity;
  MotionResult motion;
};

Scores ScoresOf(const TrackSequence& truth, const TrackSequence& tracks) {
  ParityOptions joints;
  joints.near_m = 0.050;
  joints.very_near_m = 0.025;
  return {EvaluateMpjpe(truth, tracks), EvaluateParity(truth, tracks, joints),
          EvaluateCoverage(truth, tracks), EvaluateIdentity(truth, tracks),
          EvaluateMotion(tracks, truth.header.frame_rate_hz)};
}

// IDF1: correctly identified person-frames, relative to the mean number of true
// and found person-frames.
Share Idf1Of(const IdentityResult& identity) {
  return {2 * identity.identity_true_positives,
          identity.true_person_frames + identity.found_person_frames};
}

// One row per measure, one column per mode.
Table ScoreTable(const std::vector<Scores>& all, const MotionResult& truth,
                 int64_t true_people) {
  const auto title = [](const Mode& mode) { return mode.title; };
  Table table(RowOf("against the truth", CellsOf(kModes, title)));
  const auto add = [&](const std::string& label, const auto& cell) {
    table.AddRow(RowOf(label, CellsOf(all, cell)));
  };
  add("mean joint error (MPJPE), mm",
      [](const Scores& s) { return Fixed(kMmPerM * s.error.raw_m, 1); });
  add("joints within 25 mm, %",
      [](const Scores& s) { return PercentCell(s.joints.very_near); });
  add("joints within 50 mm, %",
      [](const Scores& s) { return PercentCell(s.joints.near); });
  add("people found (coverage), %",
      [](const Scores& s) { return PercentCell(s.covered); });
  add("identities (people: " + std::to_string(true_people) + ")",
      [](const Scores& s) { return std::to_string(s.identity.identities); });
  add("identity switches",
      [](const Scores& s) { return std::to_string(s.identity.switches); });
  add("IDF1, %",
      [](const Scores& s) { return PercentCell(Idf1Of(s.identity)); });
  add("acceleration relative to the truth", [&truth](const Scores& s) {
    return Fixed(s.motion.acceleration_m_s2 / truth.acceleration_m_s2, 2);
  });
  add("bone-length spread, mm (truth: " +
          Fixed(kMmPerM * truth.bone_length_spread_m, 1) + ")",
      [](const Scores& s) {
        return Fixed(kMmPerM * s.motion.bone_length_spread_m, 1);
      });
  return table;
}

// Explains how shares are counted.
constexpr const char kLegend[] =
    "Joints within: of all joints in the truth or the result, so misses and "
    "false people\ncount as errors. People found: mean distance of the joints "
    "below 0.5 m. In brackets:\ncounts of person-frames, or of their "
    "joints.\n";

// ---- The page

// The last mode (thick) and paper mode (thin) against the truth.
void WriteDemoPage(const SyntheticRecording& recording,
                   std::vector<TrackSequence> of_modes,
                   const std::string& path) {
  PageInput input;
  input.title = "kinegraph demo: a synthetic scene";
  for (const size_t m : {std::size(kModes) - 1, size_t{0}}) {
    input.results.push_back(
        {kModes[m].title, ResultRole::kTracks, std::move(of_modes[m])});
  }
  input.results.push_back({"truth", ResultRole::kGroundTruth, recording.truth});
  input.cameras = recording.scene.cameras;
  input.detections = recording.detections;
  PageOptions options;
  options.with_covariance = true;
  WritePage(input.title, MakePageData(input, options).json, path);
}

// ---- Files

void PrintFiles(const RecordingFiles& recording,
                const std::vector<std::string>& tracks,
                const std::string& scores, const std::string& page) {
  const auto print = [](const std::string& path, const char* meaning) {
    std::printf("  %-36s %s\n", path.c_str(), meaning);
  };
  std::printf("\nWritten:\n");
  print(recording.cameras, "calibration");
  print(recording.detections, "2D detections, the input");
  print(recording.truth, "true 3D motion, a tracks file");
  print(recording.scene, "the person and the errors of each detection");
  for (size_t i = 0; i < tracks.size(); ++i) {
    print(tracks[i], kModes[i].title);
  }
  print(scores, "the table above");
  print(page, "all results as a page; open it in a browser");
}

void PrintNext(const RecordingFiles& recording,
               const std::vector<std::string>& tracks,
               const std::string& page) {
  const std::string driver = DriverName();
  std::printf(
      "\nNext, the page: open %s in a browser.\n"
      "Errors of each joint:\n"
      "  %s evaluate --protocol=mpjpe --tracks=%s \\\n"
      "    --ground_truth=%s\n"
      "A scene of your own (keys: configs/synthetic):\n"
      "  %s synthesize --config=configs/synthetic/hard.toml --out=out/hard\n"
      "Your cameras and detections (formats: docs/inputs.md):\n"
      "  %s track --cameras=%s \\\n"
      "    --detections=%s \\\n"
      "    --config=configs/synthetic/track_window.toml --out=tracks.jsonl\n",
      page.c_str(), driver.c_str(), tracks.back().c_str(),
      recording.truth.c_str(), driver.c_str(), driver.c_str(),
      recording.cameras.c_str(), recording.detections.c_str());
}

void RunDemo() {
  const std::string config = FLAGS_config.empty()
                                 ? ProjectConfig("synthetic/demo.toml")
                                 : FindConfig(FLAGS_config);
  const SyntheticRecording recording = MakeRecording(config, FLAGS_set);
  const RecordingFiles files = WriteRecording(recording, FLAGS_out);
  const std::string people = Counted(
      static_cast<int64_t>(recording.scene.people.size()), "person", "people");
  std::printf("%s, %zu cameras, %zu frames at %g Hz, %lld detections\n",
              people.c_str(), recording.scene.cameras.size(),
              recording.detections.frames.size(), recording.scene.frame_rate_hz,
              static_cast<long long>(CountDetections(recording.detections)));
  std::fflush(stdout);

  std::vector<std::string> track_files;
  std::vector<TrackSequence> of_modes;
  std::vector<Scores> scores;
  for (const Mode& mode : kModes) {
    of_modes.push_back(Track(mode, recording));
    track_files.push_back(FLAGS_out + "/" + mode.file);
    WriteTracks(track_files.back(), of_modes.back(), {true});
    scores.push_back(ScoresOf(recording.truth, of_modes.back()));
  }
  const Table table = ScoreTable(
      scores,
      EvaluateMotion(recording.truth, recording.truth.header.frame_rate_hz),
      static_cast<int64_t>(recording.scene.people.size()));
  const std::string score_file = FLAGS_out + "/scores.md";
  WriteTextFile(score_file,
                table.ToString(TableStyle::kMarkdown) + "\n" + kLegend);
  std::printf("\n%s\n%s", table.ToString().c_str(), kLegend);
  const std::string page_file = FLAGS_out + "/page.html";
  WriteDemoPage(recording, std::move(of_modes), page_file);
  PrintFiles(files, track_files, score_file, page_file);
  PrintNext(files, track_files, page_file);
}

}  // namespace
}  // namespace kinegraph

int main(int argc, char** argv) {
  return kinegraph::RunApp(
      argc, argv,
      {"demo",
       "tracks a synthetic scene in every mode and scores the results",
       "[--out=DIR]",
       {"", "--out=out/demo"}},
      kinegraph::RunDemo);
}
