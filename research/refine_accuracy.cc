// Gain of refining cameras and clocks. Synthetic recordings (5 cameras, 6
// people, 10 s, unless the fault has cameras or clips of its own) with a wrong
// calibration, wrong clocks or no fault are tracked by a batch with bones: with
// the true calibration, with the stated one, and with the one that is refined
// as in `track`.
//
//   refine_accuracy [SEEDS] [FIRST_SEED] [FAULT] [--json=FILE]
//
// SEEDS: recordings per fault (3); FIRST_SEED: 70001 if omitted; FAULT: only
// the faults whose names contain this text.
//
// Per fault: mean error of joints [mm] with the true, stated and refined
// calibration, ratio of the refined to the true one, percentage of joints in
// their 95 % ellipsoids after refinement, rms error of the refined parameters
// (degrees, px, per cent or ms) and the rms that the covariance states, how
// often the refinement was accepted, and its processor time [s].
#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "apps/common/config_folder.h"
#include "core/base/random.h"
#include "core/evaluation/mpjpe.h"
#include "research/arguments.h"
#include "solvers/session/ready_recording.h"
#include "solvers/session/run.h"
#include "tests/support/faulty_scene.h"
#include "tests/support/test_data.h"

namespace kinegraph::testing {
namespace {

constexpr double kDegrees = 180.0 / M_PI;

// Tracks files of data/motion, and the times at which their people appear [s].
using Clips = std::vector<std::pair<std::string, double>>;

struct Fault {
  std::string name;
  std::string keys;               // options of the refinement
  int place = kRotationAt;        // parameter whose error is measured
  std::vector<double> offsets_s;  // of the clocks, by view
  std::function<void(Random*, CameraRig*)> spoil;
  int cameras = 5;
  Clips clips = {};  // recorded people instead of simulated ones
};

// The same clip four times, at different phases.
Clips FourOf(const std::string& clip) {
  return {{clip, 0.0}, {clip, 0.37}, {clip, 0.74}, {clip, 1.11}};
}

std::vector<Fault> Faults() {
  const auto turned = [](double degrees) {
    return [degrees](Random* random, CameraRig* cameras) {
      for (Camera& camera : *cameras) {
        camera = Turned(camera, degrees, random->Fork());
      }
    };
  };
  const auto none = [](Random*, CameraRig*) {};
  const auto focal = [](Random* random, CameraRig* cameras) {
    for (Camera& camera : *cameras) {
      camera = Magnified(camera, random->Uniform(0.0, 1.0) < 0.5 ? 0.99 : 1.01);
    }
  };
  const auto shifted = [](Random* random, CameraRig* cameras) {
    for (Camera& camera : *cameras) {
      const double angle = random->Uniform(0.0, 2.0 * M_PI);
      camera = Shifted(camera, 15.0 * std::cos(angle), 15.0 * std::sin(angle));
    }
  };
  const auto one_turned = [](Random* random, CameraRig* cameras) {
    const auto v = static_cast<size_t>(
        random->Index(static_cast<int64_t>(cameras->size())));
    (*cameras)[v] = Turned((*cameras)[v], 2.0, random->Fork());
  };
  const std::string rotation = "cameras.refine=rotation";
  const std::string clock = "cameras.refine_clock=true";
  const std::vector<double> in_time(5, 0.0);
  const std::vector<double> off_s = {0.0, 0.08, 0.0, -0.05, 0.0};
  // Clips of five seconds: three people are followed by three others.
  const Clips hop = {{"hop_30hz", 0.0}, {"hop_30hz", 0.37}, {"hop_30hz", 0.74},
                     {"hop_30hz", 5.0}, {"hop_30hz", 5.37}, {"hop_30hz", 5.74}};
  const Clips hop_stop = FourOf("start_hop_stop_120hz");
  const Clips dance = FourOf("dance_30hz");
  return {
      {"nothing, shift", "cameras.refine=shift", kShiftAt, {}, none},
      {"nothing, rotation", rotation, kRotationAt, {}, none},
      {"nothing, pose_focal",
       "cameras.refine=pose_focal",
       kRotationAt,
       {},
       none},
      {"nothing, clock", clock, kOffsetAt, in_time, none},
      {"0.2 deg, rotation", rotation, kRotationAt, {}, turned(0.2)},
      {"0.5 deg, rotation", rotation, kRotationAt, {}, turned(0.5)},
      {"1 deg, rotation", rotation, kRotationAt, {}, turned(1.0)},
      {"0.5 deg, pose", "cameras.refine=pose", kRotationAt, {}, turned(0.5)},
      {"1 % focal, pose_focal",
       "cameras.refine=pose_focal",
       kFocalAt,
       {},
       focal},
      {"15 px centre, shift", "cameras.refine=shift", kShiftAt, {}, shifted},
      {"clocks to 80 ms", clock, kOffsetAt, off_s, none},
      {"hopping, nothing", clock, kOffsetAt, in_time, none, 5, hop},
      {"hopping, clocks to 80 ms", clock, kOffsetAt, off_s, none, 5, hop},
      {"hop and stop, clocks to 80 ms", clock, kOffsetAt, off_s, none, 5,
       hop_stop},
      {"dance, clocks to 80 ms", clock, kOffsetAt, off_s, none, 5, dance},
      {"dance, nothing", clock, kOffsetAt, in_time, none, 5, dance},
      {"hop and stop, nothing", clock, kOffsetAt, in_time, none, 5, hop_stop},
      {"clock 3 s", clock, kOffsetAt, {0.0, 3.0, 0.0, 0.0, 0.0}, none},
      {"one of 4, 2 deg", rotation, kRotationAt, {}, one_turned, 4},
  };
}

// Rms over cameras [degrees] of the rotation error in the world's axes,
// relative to the mean error of all cameras, which is a rotation of the world.
double AngleAboutMean(const CameraRig& cameras, const CameraRig& truth) {
  std::vector<Eigen::Vector3d> turns;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (size_t v = 0; v < cameras.size(); ++v) {
    const Eigen::AngleAxisd turn(
        Eigen::Matrix3d(truth[v].R().transpose() * cameras[v].R()));
    turns.push_back(kDegrees * turn.angle() * turn.axis());
    mean += turns.back() / static_cast<double>(cameras.size());
  }
  double squares = 0.0;
  for (const Eigen::Vector3d& turn : turns) {
    squares += (turn - mean).squaredNorm();
  }
  return std::sqrt(squares / static_cast<double>(turns.size()));
}

struct Sums {
  double truth_mm = 0.0, stated_mm = 0.0, refined_mm = 0.0;
  double covered = 0.0, all = 0.0;
  double squares = 0.0, stated_squares = 0.0, count = 0.0;
  double about_mean_squares = 0.0;
  double refine_s = 0.0;
  int taken = 0;
  int recordings = 0;
};

TrackSequence Tracked(const RunOptions& options, const CameraRig& cameras,
                      const DetectionSequence& recording,
                      const RefinementRecord* record) {
  RunRequest request;
  request.cameras = cameras;
  request.kept_matches = KeptMatches::kWeights;
  TrackSequence tracks = TrackSequenceOf(options, request, recording);
  if (record == nullptr) return tracks;
  const RunScene scene = PrepareScene(options, request, recording.header);
  const auto uncertainty =
      UncertaintyOf(*record, scene, recording.header.skeleton);
  for (TrackFrame& frame : tracks.frames) {
    const DetectionFrame* seen = FindDetectionFrame(recording, frame.frame);
    if (uncertainty != nullptr && seen != nullptr) {
      uncertainty->AddTo(*seen, &frame);
    }
  }
  return tracks;
}

// Adds the errors of the parameters and their stated standard deviations.
void AddParameters(const Fault& fault, const FaultyScene& scene,
                   const ReadyRecording& refined, Sums* sums) {
  for (size_t v = 0; v < scene.cameras.size(); ++v) {
    const CameraChange& sigma = refined.refinement->sigmas[v];
    if (fault.place == kRotationAt) {
      const double error =
          AngleBetween(refined.cameras[v], scene.scene.cameras[v]);
      sums->squares += error * error;
      sums->stated_squares +=
          kDegrees * kDegrees * sigma.segment<3>(kRotationAt).squaredNorm();
      sums->count += 1.0;
    } else if (fault.place == kOffsetAt && v > 0) {
      const double error_ms = 1e3 * (refined.record->cameras[v].offset_s -
                                     fault.offsets_s[v] + fault.offsets_s[0]);
      sums->squares += error_ms * error_ms;
      sums->stated_squares += std::pow(1e3 * sigma[kOffsetAt], 2);
      sums->count += 1.0;
    } else if (fault.place == kShiftAt) {
      const Eigen::Vector2d error =
          (refined.cameras[v].K() - scene.scene.cameras[v].K())
              .block<2, 1>(0, 2);
      sums->squares += error.squaredNorm();
      sums->stated_squares += sigma.segment<2>(kShiftAt).squaredNorm();
      sums->count += 1.0;
    } else if (fault.place == kFocalAt) {
      const double error = 100.0 * std::log(refined.cameras[v].focal_px() /
                                            scene.scene.cameras[v].focal_px());
      sums->squares += error * error;
      sums->stated_squares += std::pow(100.0 * sigma[kFocalAt], 2);
      sums->count += 1.0;
    }
  }
}

// A scene with larger clock errors than the generator allows: for whole
// seconds, images are moved to other frames.
FaultyScene LateScene(FaultySceneOptions options,
                      const std::vector<double>& offsets_s) {
  std::vector<int64_t> frames;
  options.clock_offset_s.clear();
  for (const double offset_s : offsets_s) {
    frames.push_back(
        std::llround(std::trunc(offset_s) * options.frame_rate_hz));
    options.clock_offset_s.push_back(offset_s - std::trunc(offset_s));
  }
  FaultyScene scene = MakeFaultyScene(options);
  const DetectionSequence in_time = scene.detections;
  const auto count = static_cast<int64_t>(in_time.frames.size());
  for (size_t v = 0; v < frames.size(); ++v) {
    for (int64_t k = 0; k < count; ++k) {
      auto& view = scene.detections.frames[static_cast<size_t>(k)].views[v];
      view.detections.clear();
      if (k + frames[v] >= count) continue;
      view.detections = in_time.frames[static_cast<size_t>(k + frames[v])]
                            .views[v]
                            .detections;
    }
  }
  return scene;
}

double ProcessorSeconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

void AddRecording(const Fault& fault, uint64_t seed, Sums* sums) {
  Random random(seed);
  FaultySceneOptions scene_options;
  scene_options.seed = random.Fork() % 1000000;
  scene_options.people = 6;
  scene_options.duration_s = 10.0;
  scene_options.cameras = fault.cameras;
  for (const auto& [clip, start_s] : fault.clips) {
    scene_options.clips.push_back(
        FindData("motion/" + clip + ".jsonl").value().string());
    scene_options.clip_start_s.push_back(start_s);
  }
  FaultyScene scene = LateScene(scene_options, fault.offsets_s);
  fault.spoil(&random, &scene.cameras);
  const TrackSequence truth = TruthOf(scene.scene);
  // The block-tridiagonal solver is faster, and equals Ceres to a tenth of a
  // millimetre.
  const std::string bare =
      "output.estimator=batch;graph.bones=true;graph.solver=sweeps";
  const RunOptions plain =
      ReadRunOptions(ProjectConfig("default.toml"), bare, "");
  const RunOptions options = ReadRunOptions(ProjectConfig("default.toml"),
                                            bare + ";" + fault.keys, "");
  RunRequest request;
  request.cameras = scene.cameras;
  const double start_s = ProcessorSeconds();
  const ReadyRecording refined =
      RefineRecording(options, request, scene.detections);
  sums->refine_s += ProcessorSeconds() - start_s;
  for (const RefineStep& step : refined.refinement->steps) {
    if (step.taken) continue;
    std::fprintf(stderr, "%s, seed %llu: %s rejected: %s\n", fault.name.c_str(),
                 static_cast<unsigned long long>(seed), step.what.c_str(),
                 step.reason.c_str());
  }
  const TrackSequence tracks =
      Tracked(plain, refined.cameras, *refined.detections, &*refined.record);
  // For the true clocks: the same people, observed by synchronous cameras.
  const DetectionSequence best =
      fault.offsets_s.empty() ? scene.detections
                              : MakeFaultyScene(scene_options).detections;
  sums->truth_mm +=
      1e3 *
      EvaluateMpjpe(truth, Tracked(plain, scene.scene.cameras, best, nullptr))
          .raw_m;
  sums->stated_mm +=
      1e3 * EvaluateMpjpe(
                truth, Tracked(plain, scene.cameras, scene.detections, nullptr))
                .raw_m;
  sums->refined_mm += 1e3 * EvaluateMpjpe(truth, tracks).raw_m;
  const Share covered = EvaluateConsistency(truth, tracks).all.covered;
  sums->covered += static_cast<double>(covered.count);
  sums->all += static_cast<double>(covered.total);
  sums->taken += refined.refinement->any_taken() ? 1 : 0;
  ++sums->recordings;
  AddParameters(fault, scene, refined, sums);
  sums->about_mean_squares +=
      std::pow(AngleAboutMean(refined.cameras, scene.scene.cameras), 2);
}

nlohmann::json Run(int seeds, uint64_t first_seed, const std::string& only) {
  nlohmann::json rows = nlohmann::json::array();
  std::printf("%-24s %7s %7s %7s %6s %8s %9s %9s %6s %6s\n", "fault, refined",
              "true", "stated", "refined", "ratio", "covered", "rms", "sigma",
              "accept", "s");
  for (const Fault& fault : Faults()) {
    if (fault.name.find(only) == std::string::npos) continue;
    if (!fault.clips.empty() && !FindData("motion").has_value()) {
      std::fprintf(stderr, "%s: needs motion/ (set KINEGRAPH_DATA), left out\n",
                   fault.name.c_str());
      continue;
    }
    Sums sums;
    for (int i = 0; i < seeds; ++i) {
      AddRecording(fault, first_seed + static_cast<uint64_t>(i), &sums);
    }
    const double recordings = sums.recordings;
    const double count = std::max(1.0, sums.count);
    const nlohmann::json row = {
        {"fault", fault.name},
        {"true_mm", sums.truth_mm / recordings},
        {"stated_mm", sums.stated_mm / recordings},
        {"refined_mm", sums.refined_mm / recordings},
        {"ratio", sums.refined_mm / sums.truth_mm},
        {"covered_percent", 100.0 * sums.covered / std::max(1.0, sums.all)},
        {"left", std::sqrt(sums.squares / count)},
        {"turned_about_mean_deg",
         std::sqrt(sums.about_mean_squares / recordings)},
        {"stated_sigma", std::sqrt(sums.stated_squares / count)},
        {"taken", sums.taken},
        {"takes", sums.recordings},
        {"refine_s", sums.refine_s / recordings}};
    const auto figure = [&](const char* key) { return row[key].get<double>(); };
    std::printf(
        "%-24s %7.2f %7.2f %7.2f %6.3f %7.1f%% %9.4f %9.4f %4d/%d %6.1f\n",
        fault.name.c_str(), figure("true_mm"), figure("stated_mm"),
        figure("refined_mm"), figure("ratio"), figure("covered_percent"),
        figure("left"), figure("stated_sigma"), sums.taken, sums.recordings,
        figure("refine_s"));
    std::fflush(stdout);
    rows.push_back(row);
  }
  return rows;
}

}  // namespace
}  // namespace kinegraph::testing

int main(int argc, char** argv) {
  std::vector<std::string> arguments(argv + 1, argv + argc);
  const std::string json_path =
      kinegraph::testing::ExtractFlag("--json=", &arguments);
  arguments.resize(3);
  const uint64_t seed =
      arguments[1].empty() ? 70001 : std::stoull(arguments[1]);
  const int seeds = arguments[0].empty() ? 3 : std::stoi(arguments[0]);
  const nlohmann::json rows =
      kinegraph::testing::Run(seeds, seed, arguments[2]);
  if (!json_path.empty()) std::ofstream(json_path) << rows.dump(1) << "\n";
  return 0;
}
