// Time of the paper-mode frame on real Shelf detections in memory, whole and by
// stage, on one core:
//
//   build/research/tracker_benchmark --benchmark_repetitions=20
//       --benchmark_report_aggregates_only=true
//
// An iteration is the whole recording of 301 frames with a new tracker; the
// counters are microseconds of processor time a frame.
#include <benchmark/benchmark.h>

#include <ctime>
#include <memory>
#include <string>
#include <vector>

#include "core/io/calibration/calibration.h"
#include "core/io/detections/source.h"
#include "core/tracking/tracker.h"
#include "solvers/session/run.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

struct BenchmarkRecording {
  RunOptions options;
  RunRequest request;
  DetectionSequence detections;
  RunScene scene;
};

// nullptr when the data is not there.
std::unique_ptr<BenchmarkRecording> LoadShelf(const std::string& config,
                                              const std::string& detections) {
  const auto calibration = testing::FindData("shelf/calibration.json");
  const auto path = testing::FindData(detections);
  if (!calibration.has_value() || !path.has_value()) return nullptr;
  auto recording = std::make_unique<BenchmarkRecording>();
  recording->options =
      ReadRunOptions(testing::ProjectFile(config).string(), "", "");
  recording->request.cameras =
      ReadCameras(calibration->string(), recording->options.cameras);
  recording->detections =
      ReadDetections(path->string(), DetectionOptionsOf(recording->options));
  recording->scene = PrepareScene(recording->options, recording->request,
                                  recording->detections.header);
  return recording;
}

// The tracker alone: frames already hold the used views in order.
void TrackRecording(const BenchmarkRecording& recording, StageTimes* times) {
  EstimatorPair estimators = MakeEstimators(recording.options.estimators);
  Tracker tracker(recording.scene.model, recording.detections.header.skeleton,
                  recording.options.tracker, estimators.feedback,
                  estimators.output);
  tracker.set_stage_times(times);
  std::vector<TrackFrame> finished;
  for (const DetectionFrame& frame : recording.detections.frames) {
    finished.clear();
    tracker.Process(frame, &finished);
    benchmark::DoNotOptimize(finished.data());
  }
  tracker.Finish(&finished);
}

void SetPerFrame(benchmark::State* state, const char* name, double seconds,
                 const BenchmarkRecording& recording) {
  const double frames =
      static_cast<double>(recording.detections.frames.size()) *
      static_cast<double>(state->iterations());
  state->counters[name] = 1e6 * seconds / frames;
}

void WholeFrame(benchmark::State& state, const std::string& config,
                const std::string& detections) {
  const auto recording = LoadShelf(config, detections);
  if (recording == nullptr) {
    state.SkipWithError("needs real data (set KINEGRAPH_DATA)");
    return;
  }
  const std::clock_t start = std::clock();
  for (auto _ : state) TrackRecording(*recording, nullptr);
  const double seconds =
      static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  SetPerFrame(&state, "us_per_frame", seconds, *recording);
}

void ByStage(benchmark::State& state, const std::string& config,
             const std::string& detections) {
  const auto recording = LoadShelf(config, detections);
  if (recording == nullptr) {
    state.SkipWithError("needs real data (set KINEGRAPH_DATA)");
    return;
  }
  StageTimes times;
  for (auto _ : state) TrackRecording(*recording, &times);
  const auto set = [&](const char* name, int64_t nanoseconds) {
    SetPerFrame(&state, name, 1e-9 * static_cast<double>(nanoseconds),
                *recording);
  };
  set("1_prepare", times.preparation_ns);
  set("2_associate", times.association_ns);
  set("3_reconstruct", times.reconstruction_ns);
  set("4_smooth", times.estimation_ns);
  set("5_initialise", times.initialisation_ns);
  set("6_output", times.output_ns);
}

const char kText[] = "configs/paper/shelf.toml";
const char kAuthors[] = "configs/paper/shelf_authors_code.toml";
const char kRaw[] = "shelf/detections/openpose";
const char kFilled[] = "shelf/reference/filled_coco17";

BENCHMARK_CAPTURE(WholeFrame, raw, kText, kRaw)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(WholeFrame, filled, kAuthors, kFilled)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(ByStage, raw, kText, kRaw)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(ByStage, filled, kAuthors, kFilled)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace kinegraph

BENCHMARK_MAIN();
