// How the time of a paper-mode frame grows with cameras, people and joints, on
// synthetic scenes in memory, on one core:
//
//   build/research/growth_benchmark [--json=FILE]
//
// An iteration tracks a recording of one second; its time is the processor time
// of the frames after everybody was found, so that a busy machine disturbs
// little. Of the iterations the fastest counts. (The very first frame, in which
// all people are new and every detection meets every other, is listed apart.) A
// table then sets the measured times against
//
//   a cameras people^2 + b cameras^2 people
//
// (every track meets every detection of every view; every pair of views meets
// in the joints filter). a and b are fitted, for each number of joints, to the
// small sizes alone, by least squares of the relative error.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "apps/common/table.h"
#include "core/synthetic/body.h"
#include "core/synthetic/noise.h"
#include "core/synthetic/scene.h"
#include "core/system/clock.h"
#include "core/tracking/tracker.h"
#include "solvers/session/run.h"

namespace kinegraph {
namespace {

using Json = nlohmann::json;

constexpr int kWarmUpFrames = 5;

struct Size {
  int joints = 0;
  int cameras = 0;
  int people = 0;
};
bool operator<(const Size& a, const Size& b) {
  return std::array{a.joints, a.cameras, a.people} <
         std::array{b.joints, b.cameras, b.people};
}

struct Times {
  double frame_us = 1e12;  // fastest, of a frame in which everybody is known
  double first_us = 1e12;  // fastest, of the frame in which all are new
};

std::map<Size, Times>& Measured() {
  static std::map<Size, Times> measured;
  return measured;
}

Skeleton SkeletonOf(int joints) {
  if (joints == Coco17().joint_count()) return Coco17();
  if (joints == Body25().joint_count()) return Body25();
  return WholeBody133();
}

// The same ground for all sizes; 20 people have room, 32 cameras stand apart.
Scene MakeSceneOf(const Size& size) {
  SceneOptions options;
  options.seed = 17;
  options.people = size.people;
  options.duration_s = 1.2;
  options.motion.area_radius_m = 4.0;
  options.motion.visitors = 0.0;
  options.cameras.count = size.cameras;
  options.cameras.radius_m = 9.0;
  options.cameras.distortion = {-0.1, 0.02, 0.0, 0.0, 0.0};
  return MakeScene(options, SkeletonOf(size.joints));
}

// Enough noise that the joints filter finds conflicts to settle.
DetectionSequence DetectionsOf(const Scene& scene) {
  NoiseOptions noise;
  noise.seed = 5;
  noise.joints.sigma_px = 3.0;
  noise.joints.outlier_rate = 0.02;
  noise.joints.outlier_max_px = 120.0;
  noise.joints.missing_rate = 0.05;
  return Observe(scene, noise, nullptr);
}

double ProcessorSeconds() { return 1e-9 * static_cast<double>(ThreadCpuNs()); }

void Frame(benchmark::State& state) {
  const Size size = {static_cast<int>(state.range(0)),
                     static_cast<int>(state.range(1)),
                     static_cast<int>(state.range(2))};
  const Scene scene = MakeSceneOf(size);
  const DetectionSequence detections = DetectionsOf(scene);
  const SceneModel model = {scene.cameras, scene.skeleton, scene.frame_rate_hz,
                            KeptMatches::kNone};
  const auto timed_frames =
      static_cast<double>(detections.frames.size() - kWarmUpFrames);
  Times fastest;
  size_t tracked = 0;
  for (auto _ : state) {
    EstimatorOptions paper;
    paper.mode = Mode::kPaper;
    EstimatorPair estimators = MakeEstimators(paper);
    Tracker tracker(model, scene.skeleton, TrackerOptions(),
                    estimators.feedback, estimators.output);
    std::vector<TrackFrame> finished;
    double start_s = ProcessorSeconds();
    for (size_t f = 0; f < detections.frames.size(); ++f) {
      if (f == kWarmUpFrames) start_s = ProcessorSeconds();
      finished.clear();
      tracker.Process(detections.frames[f], &finished);
      benchmark::DoNotOptimize(finished.data());
      if (f == 0) {
        fastest.first_us =
            std::min(fastest.first_us, 1e6 * (ProcessorSeconds() - start_s));
      }
    }
    const double seconds = ProcessorSeconds() - start_s;
    state.SetIterationTime(seconds);
    fastest.frame_us = std::min(fastest.frame_us, 1e6 * seconds / timed_frames);
    tracked = tracker.track_count();
  }
  if (tracked != static_cast<size_t>(size.people)) {
    state.SkipWithError("not everybody is tracked");
    return;
  }
  Measured()[size] = fastest;
  state.counters["us_per_frame"] = fastest.frame_us;
}

BENCHMARK(Frame)
    ->ArgNames({"joints", "cameras", "people"})
    ->ArgsProduct({{17, 25, 133}, {4, 8, 16, 32}, {1, 2, 5, 10, 20}})
    ->UseManualTime()
    ->Iterations(5)
    ->Unit(benchmark::kMillisecond);

// ---- The model

struct Growth {
  double a = 0.0;
  double b = 0.0;

  double Predict(const Size& size) const {
    const double c = size.cameras;
    const double p = size.people;
    return a * c * p * p + b * c * c * p;
  }
};

bool IsSmall(const Size& size) { return size.cameras <= 8 && size.people <= 5; }

// Least squares of (model - measured) / measured over the small sizes, both
// coefficients at least 0.
Growth Fit(const std::map<Size, Times>& measured) {
  double xx = 0.0, xy = 0.0, yy = 0.0, x = 0.0, y = 0.0;
  for (const auto& [size, times] : measured) {
    if (!IsSmall(size)) continue;
    const double us = times.frame_us;
    const double u = Growth{1.0, 0.0}.Predict(size) / us;
    const double v = Growth{0.0, 1.0}.Predict(size) / us;
    xx += u * u;
    xy += u * v;
    yy += v * v;
    x += u;
    y += v;
  }
  const double determinant = xx * yy - xy * xy;
  Growth growth = {(x * yy - y * xy) / determinant,
                   (y * xx - x * xy) / determinant};
  if (growth.a < 0.0) growth = {0.0, y / yy};
  if (growth.b < 0.0) growth = {x / xx, 0.0};
  return growth;
}

// The largest factor by which a frame takes longer when `grow` doubles a size.
template <typename Grow>
double LargestStep(const std::map<Size, Times>& measured, const Grow& grow) {
  double largest = 0.0;
  for (const auto& [size, times] : measured) {
    Size doubled = size;
    grow(&doubled);
    const auto at = measured.find(doubled);
    if (at == measured.end()) continue;
    largest = std::max(largest, at->second.frame_us / times.frame_us);
  }
  return largest;
}

// What it prints.
Json PrintGrowth(int joints, const std::map<Size, Times>& measured) {
  const Growth growth = Fit(measured);
  std::printf(
      "\n%d joints: %.3f us cameras people^2 + %.3f us cameras^2 people, "
      "fitted to at most 8 cameras and 5 people\n",
      joints, growth.a, growth.b);
  Table table({"cameras", "people", "measured us", "model us",
               "measured / model", "", "first frame us"});
  double worst = 0.0;
  Json frames;
  for (const auto& [size, times] : measured) {
    const double ratio = times.frame_us / growth.Predict(size);
    if (!IsSmall(size)) worst = std::max(worst, ratio);
    table.AddRow({std::to_string(size.cameras), std::to_string(size.people),
                  Fixed(times.frame_us, 1), Fixed(growth.Predict(size), 1),
                  Fixed(ratio, 2), IsSmall(size) ? "fitted" : "predicted",
                  Fixed(times.first_us, 1)});
    frames[std::to_string(size.cameras) + " cameras, " +
           std::to_string(size.people) + " people"] = {
        {"us", times.frame_us}, {"ratio", ratio}, {"first_us", times.first_us}};
  }
  const double by_cameras =
      LargestStep(measured, [](Size* size) { size->cameras *= 2; });
  const double by_people =
      LargestStep(measured, [](Size* size) { size->people *= 2; });
  std::printf(
      "%slargest measured / model beyond the fit: %.2f\n"
      "twice the cameras take at most %.2f times as long, twice the people "
      "%.2f times (the model: up to 4)\n",
      table.ToString().c_str(), worst, by_cameras, by_people);
  return {{"frames", frames},
          {"worst", worst},
          {"twice_cameras", by_cameras},
          {"twice_people", by_people}};
}

Json PrintAll() {
  Json all;
  std::map<int, std::map<Size, Times>> by_joints;
  for (const auto& [size, times] : Measured()) {
    by_joints[size.joints][size] = times;
  }
  for (const auto& [joints, measured] : by_joints) {
    all[std::to_string(joints) + " joints"] = PrintGrowth(joints, measured);
  }
  return all;
}

}  // namespace
}  // namespace kinegraph

int main(int argc, char** argv) {
  std::string json_path;
  const std::string flag = "--json=";
  if (argc > 1 && std::string(argv[argc - 1]).rfind(flag, 0) == 0) {
    json_path = std::string(argv[--argc]).substr(flag.size());
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  const nlohmann::json all = kinegraph::PrintAll();
  if (!json_path.empty()) std::ofstream(json_path) << all.dump(1) << "\n";
  return 0;
}
