// Time of the factor-graph estimators per person and frame: 17 joints, five
// views, schedule, construction, marginalisation and finals included. Divide
// the reported time by the frames: the counter "per_person_frame" does.
#include <benchmark/benchmark.h>

#include "solvers/batch/batch_estimator.h"
#include "solvers/window/window_estimator.h"
#include "tests/support/simulated_person.h"

namespace kinegraph {
namespace {

struct World {
  SceneModel scene;
  testing::SimulatedTake take;
};

World MakeWorld(int frames) {
  World world;
  world.scene.cameras = testing::RingOfCameras(5, 5.0, 1000.0);
  world.scene.skeleton = Coco17();
  world.scene.frame_rate_hz = 25.0;
  testing::SimulatedNoise noise;
  noise.correlation_time_s = 0.1;
  noise.missing = 0.1;
  noise.outliers = 0.05;
  noise.outlier_burst = 3;
  noise.confidence_low = 0.3;
  Random random(61);
  world.take = testing::Simulate(world.scene, testing::FixedNoise(),
                                 testing::WalkingMotion(world.scene, frames),
                                 noise, Eigen::Vector3d::Zero(), &random);
  world.take.Connect();
  return world;
}

// Arguments: bones, covariances, Ceres.
GraphOptions Options(const benchmark::State& state) {
  GraphOptions options = testing::FixedNoise();
  options.bones = state.range(0) != 0;
  options.covariance = state.range(1) != 0;
  options.solver =
      state.range(2) != 0 ? GraphSolver::kCeres : GraphSolver::kSweeps;
  return options;
}

void Count(benchmark::State& state, int frames) {
  state.counters["per_person_frame"] =
      benchmark::Counter(frames, benchmark::Counter::kIsIterationInvariantRate |
                                     benchmark::Counter::kInvert);
}

template <typename MakeEstimator>
void RunTake(benchmark::State& state, int frames, const MakeEstimator& make) {
  World world = MakeWorld(frames);
  world.take.Connect();
  const GraphOptions options = Options(state);
  for (auto _ : state) {
    const auto estimator = make(world.scene, options);
    benchmark::DoNotOptimize(testing::Run(estimator.get(), world.take.frames));
  }
  Count(state, frames);
}

void BM_Window(benchmark::State& state) {
  RunTake(state, 100, [](const SceneModel& scene, const GraphOptions& options) {
    return MakeWindowEstimator(scene, options);
  });
}

void BM_Batch(benchmark::State& state) {
  RunTake(state, 300, [](const SceneModel& scene, const GraphOptions& options) {
    return MakeBatchEstimator(scene, options);
  });
}

void Modes(benchmark::internal::Benchmark* bench) {
  bench->ArgNames({"bones", "covariance", "ceres"})
      ->Unit(benchmark::kMillisecond);
  for (const int ceres : {0, 1}) {
    for (const int bones : {0, 1}) {
      for (const int covariance : {0, 1}) {
        bench->Args({bones, covariance, ceres});
      }
    }
  }
}

BENCHMARK(BM_Window)->Apply(Modes);
BENCHMARK(BM_Batch)->Apply(Modes);

}  // namespace
}  // namespace kinegraph

BENCHMARK_MAIN();
