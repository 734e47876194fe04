// Time of the paper-mode frame on real Shelf detections in memory, whole and
// by stage, on one core:
//
//   build/research/tracker_benchmark --benchmark_repetitions=20
//       --benchmark_report_aggregates_only=true
//
// An iteration is the whole take of 301 frames with a new tracker; the counters
// are microseconds of processor time a frame.
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

struct Take {
  RunOptions options;
  RunRequest request;
  DetectionSequence detections;
  RunScene scene;
};

// nullptr when the data is not there.
std::unique_ptr<Take> LoadShelf(const std::string& config,
                                const std::string& detections) {
  const auto calibration = testing::FindData("shelf/calibration.json");
  const auto path = testing::FindData(detections);
  if (!calibration.has_value() || !path.has_value()) return nullptr;
  auto take = std::make_unique<Take>();
  take->options = ReadRunOptions(testing::ProjectFile(config).string(), "", "");
  take->request.cameras =
      ReadCameras(calibration->string(), take->options.cameras);
  take->detections =
      ReadDetections(path->string(), DetectionOptionsOf(take->options));
  take->scene =
      PrepareScene(take->options, take->request, take->detections.header);
  return take;
}

// The tracker alone: frames already hold the used views in order.
void TrackTake(const Take& take, StageTimes* times) {
  EstimatorPair estimators = MakeEstimators(take.options.estimators);
  Tracker tracker(take.scene.model, take.detections.header.skeleton,
                  take.options.tracker, estimators.feedback, estimators.output);
  tracker.set_stage_times(times);
  std::vector<TrackFrame> finished;
  for (const DetectionFrame& frame : take.detections.frames) {
    finished.clear();
    tracker.Process(frame, &finished);
    benchmark::DoNotOptimize(finished.data());
  }
  tracker.Finish(&finished);
}

void SetPerFrame(benchmark::State* state, const char* name, double seconds,
                 const Take& take) {
  const double frames = static_cast<double>(take.detections.frames.size()) *
                        static_cast<double>(state->iterations());
  state->counters[name] = 1e6 * seconds / frames;
}

void WholeFrame(benchmark::State& state, const std::string& config,
                const std::string& detections) {
  const auto take = LoadShelf(config, detections);
  if (take == nullptr) {
    state.SkipWithError("needs real data (set KINEGRAPH_DATA)");
    return;
  }
  const std::clock_t start = std::clock();
  for (auto _ : state) TrackTake(*take, nullptr);
  const double seconds =
      static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  SetPerFrame(&state, "us_per_frame", seconds, *take);
}

void ByStage(benchmark::State& state, const std::string& config,
             const std::string& detections) {
  const auto take = LoadShelf(config, detections);
  if (take == nullptr) {
    state.SkipWithError("needs real data (set KINEGRAPH_DATA)");
    return;
  }
  StageTimes times;
  for (auto _ : state) TrackTake(*take, &times);
  const auto set = [&](const char* name, int64_t nanoseconds) {
    SetPerFrame(&state, name, 1e-9 * static_cast<double>(nanoseconds), *take);
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
