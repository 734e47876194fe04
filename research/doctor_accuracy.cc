// How often the doctor identifies a fault in the description of a recording,
// and how often it reports a fault in a sound one. Each kind of fault is
// applied to synthetic scenes, with seeds other than those of the tests and a
// detector that has constant offsets.
//
//   doctor_accuracy [SCENES_PER_KIND] [FIRST_SEED] [KIND] [--json=FILE]
//
// Prints one line per kind: the numbers of scenes, of scenes whose fault was
// identified ("named"), of scenes with a finding of another kind whose
// confidence is 0.8 or more ("wrong"), and of verdicts "suspect"; then totals
// with one-sided 95 % limits (Clopper and Pearson 1934).
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "core/base/random.h"
#include "research/arguments.h"
#include "tests/support/faulty_scene.h"
#include "tests/support/test_data.h"

namespace kinegraph::testing {
namespace {

struct Fault {
  std::string name;
  // The kinds of findings that identify the fault. Empty: the scene is sound.
  std::set<std::string> kinds;
  std::function<void(Random*, FaultySceneOptions*)> options;
  std::function<void(Random*, FaultyScene*)> spoil;
  bool recorded = false;  // people from data/motion
};

size_t Any(Random* random, const FaultyScene& scene) {
  return static_cast<size_t>(
      random->Index(static_cast<int64_t>(scene.cameras.size())));
}

void EachPose(FaultyScene* scene,
              const std::function<Camera(const Camera&)>& stated) {
  for (Camera& camera : scene->cameras) camera = stated(camera);
}

// Rotates the images of view `v`; 0 quarter turns: mirrors them instead.
void TurnImages(FaultyScene* scene, size_t v, int quarter_turns) {
  const double width = scene->cameras[v].width_px();
  const double height = scene->cameras[v].height_px();
  for (DetectionFrame& frame : scene->detections.frames) {
    for (Detection& detection : frame.views[v].detections) {
      for (Keypoint& joint : detection.joints) {
        const Eigen::Vector2d px = joint.px;
        if (quarter_turns == 1) joint.px = {height - 1.0 - px.y(), px.x()};
        if (quarter_turns == 2)
          joint.px = {width - 1.0 - px.x(), height - 1.0 - px.y()};
        if (quarter_turns == 3) joint.px = {px.y(), width - 1.0 - px.x()};
        if (quarter_turns == 0) joint.px = {width - 1.0 - px.x(), px.y()};
      }
    }
  }
}

// Scales camera matrices to images of another size.
void ScaleImages(const std::function<double(const Camera&)>& factor,
                 FaultyScene* scene) {
  for (Camera& camera : scene->cameras) {
    CameraParameters parameters = camera.parameters();
    parameters.K.topRows<2>() *= factor(camera);
    camera = Camera(parameters);
  }
}

// States a frame rate `factor` times the true one, with frame times to match.
void StateRate(double factor, FaultyScene* scene) {
  scene->scene.frame_rate_hz *= factor;
  scene->detections.header.frame_rate_hz *= factor;
  for (DetectionFrame& frame : scene->detections.frames) {
    frame.time = FromSeconds(ToSeconds(frame.time) / factor);
    for (ViewDetections& view : frame.views) {
      view.capture_time = FromSeconds(ToSeconds(view.capture_time) / factor);
    }
  }
}

std::vector<Fault> Faults() {
  const auto plain = [](Random*, FaultySceneOptions*) {};
  const auto leave = [](Random*, FaultyScene*) {};
  const auto pose = [](const std::function<Camera(const Camera&)>& stated) {
    return [stated](Random*, FaultyScene* scene) { EachPose(scene, stated); };
  };
  // The images of one view of five are later than stated by this much.
  const auto late = [](double offset_s) {
    return [offset_s](Random* random, FaultySceneOptions* o) {
      o->clock_offset_s.assign(5, 0.0);
      o->clock_offset_s[static_cast<size_t>(random->Index(5))] = offset_s;
    };
  };
  // Three people who hop (data/motion), at different phases.
  const auto hop = [](FaultySceneOptions* o) {
    o->clips.assign(3, FindData("motion/hop_30hz.jsonl").value().string());
    o->clip_start_s = {0.0, 0.37, 0.74};
  };
  const std::vector<double> lens = {-0.28, 0.1, 0.0, 0.0, 0.0};
  return {
      {"sound", {}, plain, leave},
      {"sound, with a lens",
       {},
       [lens](Random*, FaultySceneOptions* o) { o->distortion = lens; },
       leave},
      {"sound, people hop",
       {},
       [hop](Random*, FaultySceneOptions* o) { hop(o); },
       leave,
       true},
      {"unit",
       {"unit"},
       plain,
       [](Random* random, FaultyScene* scene) {
         const double factors[] = {1000.0, 100.0, 10.0, 0.001, 0.01, 0.1};
         const double factor = factors[random->Index(6)];
         EachPose(scene, [&](const Camera& c) {
           return WithExtrinsics(c, c.R(), factor * c.t());
         });
       }},
      {"camera to world", {"convention"}, plain, pose([](const Camera& c) {
         return WithExtrinsics(c, c.R().transpose(), c.centre());
       })},
      {"centre for translation",
       {"convention"},
       plain,
       pose([](const Camera& c) {
         return WithExtrinsics(c, c.R(), c.centre());
       })},
      {"rows for columns", {"convention"}, plain, pose([](const Camera& c) {
         return WithExtrinsics(c, c.R().transpose(), c.t());
       })},
      {"lens on undistorted pixels",
       {"lens"},
       [](Random*, FaultySceneOptions*) {},
       [lens](Random*, FaultyScene* scene) {
         for (Camera& camera : scene->cameras) {
           CameraParameters parameters = camera.parameters();
           parameters.lens = MakeLens("opencv5", lens);
           camera = Camera(parameters);
         }
       }},
      {"lens terms forgotten",
       {"lens"},
       [lens](Random*, FaultySceneOptions* o) { o->distortion = lens; },
       [](Random*, FaultyScene* scene) {
         for (Camera& camera : scene->cameras) {
           camera = testing::WithoutLens(camera);
         }
       }},
      {"camera matrix of images half as large",
       {"intrinsics"},
       plain,
       [](Random*, FaultyScene* scene) {
         ScaleImages([](const Camera&) { return 0.5; }, scene);
       }},
      {"camera matrix divided by the images' width",
       {"intrinsics"},
       plain,
       [](Random*, FaultyScene* scene) {
         ScaleImages([](const Camera& c) { return 1.0 / c.width_px(); }, scene);
       }},
      {"one view's images turned or mirrored",
       {"image"},
       plain,
       [](Random* random, FaultyScene* scene) {
         TurnImages(scene, Any(random, *scene),
                    static_cast<int>(random->Index(4)));
       }},
      {"two views exchanged",
       {"swapped_views"},
       plain,
       [](Random* random, FaultyScene* scene) {
         const size_t a = Any(random, *scene);
         const size_t b =
             (a + 1 +
              static_cast<size_t>(random->Index(
                  static_cast<int64_t>(scene->cameras.size() - 1)))) %
             scene->cameras.size();
         // Views are paired by names, which are kept.
         CameraParameters one = scene->cameras[a].parameters();
         CameraParameters other = scene->cameras[b].parameters();
         std::swap(one.name, other.name);
         scene->cameras[a] = Camera(other);
         scene->cameras[b] = Camera(one);
       }},
      {"a neighbour's calibration",
       {"never_matched"},
       plain,
       [](Random* random, FaultyScene* scene) {
         const size_t a = Any(random, *scene);
         const size_t b = (a + 1) % scene->cameras.size();
         CameraParameters parameters = scene->cameras[a].parameters();
         parameters.name = scene->cameras[b].name();
         scene->cameras[b] = Camera(parameters);
       }},
      {"one camera turned by 1 degree",
       {"rotation", "shift"},
       plain,
       [](Random* random, FaultyScene* scene) {
         const size_t v = Any(random, *scene);
         scene->cameras[v] = Turned(scene->cameras[v], 1.0, random->Fork());
       }},
      {"one image shifted by 15 px",
       {"shift", "rotation"},
       plain,
       [](Random* random, FaultyScene* scene) {
         const size_t v = Any(random, *scene);
         const double angle = random->Uniform(0.0, 6.28);
         scene->cameras[v] = Shifted(scene->cameras[v], 15.0 * std::cos(angle),
                                     15.0 * std::sin(angle));
       }},
      {"one focal length off by 5 %",
       {"focal_length"},
       plain,
       [](Random* random, FaultyScene* scene) {
         const size_t v = Any(random, *scene);
         const double factor = random->Index(2) == 0 ? 1.05 : 0.95;
         scene->cameras[v] = Magnified(scene->cameras[v], factor);
       }},
      {"one clock off by 0.96 s",
       {"clock_offset"},
       [](Random* random, FaultySceneOptions* o) {
         o->duration_s = 12.0;
         o->clock_offset_s.assign(5, 0.0);
         o->clock_offset_s[static_cast<size_t>(random->Index(5))] = 0.96;
       },
       leave},
      {"one view loses two pictures",
       {"frames"},
       [](Random*, FaultySceneOptions* o) { o->duration_s = 12.0; },
       [](Random* random, FaultyScene* scene) {
         const size_t v = Any(random, *scene);
         auto& frames = scene->detections.frames;
         const auto count = static_cast<int64_t>(frames.size());
         const auto from = static_cast<size_t>(
             count / 4 + static_cast<int64_t>(random->Index(count / 2)));
         for (size_t k = from; k < frames.size(); ++k) {
           auto& lost = frames[k].views[v].detections;
           lost.clear();
           if (k + 2 < frames.size()) lost = frames[k + 2].views[v].detections;
         }
       }},
      {"one view repeats every 50th picture",
       {"frames"},
       plain,
       [](Random* random, FaultyScene* scene) {
         const size_t v = Any(random, *scene);
         auto& frames = scene->detections.frames;
         for (size_t k = 50; k < frames.size(); k += 50) {
           frames[k].views[v] = frames[k - 1].views[v];
         }
       }},
      {"frame rate read ten times too high",
       {"frame_rate"},
       plain,
       [](Random*, FaultyScene* scene) { StateRate(10.0, scene); }},
      {"75 s between frames",
       {"frame_rate"},
       plain,
       [](Random*, FaultyScene* scene) {
         StateRate(1.0 / (75.0 * scene->scene.frame_rate_hz), scene);
       }},
      {"joints of BODY_25B read as BODY_25's",
       {"skeleton"},
       [](Random*, FaultySceneOptions* o) { o->skeleton = "body25b"; },
       [](Random*, FaultyScene* scene) {
         scene->detections.header.skeleton = Body25();
       }},
      {"one camera turned by 1 degree in the middle",
       {"rotation", "shift"},
       [](Random*, FaultySceneOptions* o) { o->duration_s = 12.0; },
       [](Random* random, FaultyScene* scene) {
         const size_t v = Any(random, *scene);
         const auto count =
             static_cast<int64_t>(scene->detections.frames.size());
         const auto from = static_cast<size_t>(
             count / 4 + static_cast<int64_t>(random->Index(count / 2)));
         testing::TurnCameraFrom(from, v, 1.0, random->Fork(), scene);
       }},
      {"one clock off by 60 ms", {"clock_offset"}, late(0.06), leave},
      {"one clock off by 120 ms", {"clock_offset"}, late(0.12), leave},
      {"one clock off by 0.2 s", {"clock_offset"}, late(0.2), leave},
      {"one clock late by 2 ms more each second",
       {"clock_drift", "clock_offset"},
       [](Random* random, FaultySceneOptions* o) {
         o->people = 2;
         o->duration_s = 30.0;
         o->clock_drift.assign(5, 0.0);
         o->clock_drift[static_cast<size_t>(random->Index(5))] = 0.002;
       },
       leave},
      {"people hop, one clock off by 60 ms",
       {"clock_offset"},
       [hop](Random* random, FaultySceneOptions* o) {
         hop(o);
         o->clock_offset_s.assign(5, 0.0);
         o->clock_offset_s[static_cast<size_t>(random->Index(5))] = 0.06;
       },
       leave,
       true},
      {"two people, every camera turned by 1 degree",
       {"rotation", "shift"},
       [](Random*, FaultySceneOptions* o) { o->people = 2; },
       [](Random* random, FaultyScene* scene) {
         for (Camera& camera : scene->cameras) {
           camera = Turned(camera, 1.0, random->Fork());
         }
       }},
  };
}

// Logarithm of the binomial coefficient n choose k.
double LogChoose(int n, int k) {
  return std::lgamma(n + 1.0) - std::lgamma(k + 1.0) - std::lgamma(n - k + 1.0);
}

// Upper one-sided 95 % limit of a rate if `k` of `n` were observed: the rate
// for which k or fewer have a probability of 5 %.
double UpperLimit(int k, int n) {
  if (k >= n) return 1.0;
  double low = 0.0;
  double high = 1.0;
  for (int i = 0; i < 60; ++i) {
    const double p = 0.5 * (low + high);
    double chance = 0.0;
    for (int j = 0; j <= k; ++j) {
      chance += std::exp(LogChoose(n, j) + j * std::log(p) +
                         (n - j) * std::log1p(-p));
    }
    (chance > 0.05 ? low : high) = p;
  }
  return high;
}

// Prints all findings of a scene to standard error. Called if the fault was not
// identified, another one was reported with confidence, or a sound scene has
// findings.
void PrintFindings(const std::string& fault, uint64_t seed,
                   const Diagnosis& diagnosis) {
  std::fprintf(stderr, "%s, scene %llu: %s\n", fault.c_str(),
               static_cast<unsigned long long>(seed),
               ToString(diagnosis.verdict));
  for (const Finding& finding : diagnosis.findings) {
    std::fprintf(stderr, "  %s of %s, %.2f: %s\n", finding.kind.c_str(),
                 finding.camera.c_str(), finding.confidence,
                 finding.evidence.c_str());
  }
}

nlohmann::json Run(int scenes, uint64_t first_seed, const std::string& only) {
  nlohmann::json rows = nlohmann::json::array();
  constexpr double kConfident = 0.8;
  std::printf("%-40s %6s %6s %6s %9s\n", "fault", "n", "named", "wrong",
              "suspect");
  int all = 0, all_named = 0, all_wrong = 0;
  int sound = 0, false_alarms = 0;
  for (const Fault& fault : Faults()) {
    if (!only.empty() && fault.name.find(only) == std::string::npos) continue;
    if (fault.recorded && !FindData("motion").has_value()) {
      std::fprintf(stderr, "%s: needs motion/ (set KINEGRAPH_DATA), left out\n",
                   fault.name.c_str());
      continue;
    }
    int named = 0, wrong = 0, suspect = 0;
    for (int i = 0; i < scenes; ++i) {
      // The length of the name gives most kinds scenes of their own.
      Random random(first_seed + 1000 * static_cast<uint64_t>(i) +
                    fault.name.size());
      FaultySceneOptions options;
      options.seed = random.Fork() % 1000000;
      options.duration_s = 6.0;
      fault.options(&random, &options);
      FaultyScene scene = MakeFaultyScene(options);
      AddLastingOffsets(options.seed + 1, 1.0, &scene);
      fault.spoil(&random, &scene);
      const Diagnosis diagnosis = DiagnoseScene(scene);
      bool is_named = false;
      bool is_wrong = false;
      for (const Finding& finding : diagnosis.findings) {
        const bool right = fault.kinds.count(finding.kind) > 0;
        is_named = is_named || right;
        is_wrong = is_wrong || (!right && finding.confidence >= kConfident);
      }
      const bool is_right =
          fault.kinds.empty() ? diagnosis.findings.empty() : is_named;
      if (is_wrong || !is_right)
        PrintFindings(fault.name, options.seed, diagnosis);
      named += is_named;
      wrong += is_wrong;
      suspect += diagnosis.verdict == DoctorVerdict::kSuspect;
    }
    std::printf("%-40s %6d %6d %6d %9d\n", fault.name.c_str(), scenes, named,
                wrong, suspect);
    std::fflush(stdout);
    rows.push_back({{"fault", fault.name},
                    {"scenes", scenes},
                    {"sound", fault.kinds.empty()},
                    {"named", named},
                    {"wrong", wrong},
                    {"suspect", suspect}});
    if (fault.kinds.empty()) {
      sound += scenes;
      false_alarms += suspect;
    } else {
      all += scenes;
      all_named += named;
      all_wrong += wrong;
    }
  }
  if (all > 0) {
    std::printf(
        "identified %d of %d; not identified: at most %.1f %% (95 %%)\n",
        all_named, all, 100.0 * UpperLimit(all - all_named, all));
    std::printf("confidently wrong %d of %d: at most %.1f %% (95 %%)\n",
                all_wrong, all, 100.0 * UpperLimit(all_wrong, all));
  }
  if (sound > 0) {
    std::printf("false alarms %d of %d: at most %.1f %% (95 %%)\n",
                false_alarms, sound, 100.0 * UpperLimit(false_alarms, sound));
  }
  const auto rate = [](int k, int n) {
    return nlohmann::json{{"count", k},
                          {"total", n},
                          {"at_most_percent", 100.0 * UpperLimit(k, n)}};
  };
  return {{"faults", rows},
          {"not_named", rate(all - all_named, all)},
          {"wrong", rate(all_wrong, all)},
          {"false_alarms", rate(false_alarms, sound)}};
}

}  // namespace
}  // namespace kinegraph::testing

int main(int argc, char** argv) {
  std::vector<std::string> arguments(argv + 1, argv + argc);
  const std::string json_path =
      kinegraph::testing::ExtractFlag("--json=", &arguments);
  arguments.resize(3);
  const std::string& scenes = arguments[0];
  const std::string& seed = arguments[1];
  const nlohmann::json all = kinegraph::testing::Run(
      scenes.empty() ? 5 : std::stoi(scenes),
      seed.empty() ? 90001 : std::stoull(seed), arguments[2]);
  if (!json_path.empty()) std::ofstream(json_path) << all.dump(1) << "\n";
  return 0;
}
