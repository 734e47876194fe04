#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "apps/report/page_data.h"
#include "core/base/error.h"
#include "core/synthetic/noise.h"
#include "core/synthetic/scene.h"
#include "solvers/session/options.h"
#include "solvers/session/run.h"
#include "tests/fuzz/input_file.h"
#include "tests/fuzz/targets.h"

namespace kinegraph::testing {
namespace {

// The bytes choose a small valid scene; the whole pipeline must give finite
// positions, and ascending frames with ascending ids of people.
bool FuzzScene(const std::string& bytes) {
  const auto byte = [&](size_t at) -> int {
    return at < bytes.size() ? static_cast<uint8_t>(bytes[at]) : 0;
  };
  const auto share = [&](size_t at) { return byte(at) / 255.0; };
  SceneOptions scene_options;
  scene_options.seed = static_cast<uint64_t>(byte(0));
  scene_options.people = 1 + byte(1) % 4;
  scene_options.duration_s = 0.2 + 0.6 * share(2);
  scene_options.cameras.count = 2 + byte(3) % 4;
  NoiseOptions noise;
  noise.seed = static_cast<uint64_t>(byte(4));
  noise.joints.missing_rate = 0.5 * share(5);
  noise.joints.outlier_rate = 0.5 * share(6);
  noise.missed_rate = 0.5 * share(7);
  noise.false_people = 2.0 * share(8);
  RunOptions options;
  options.estimators.mode = byte(9) % 2 == 0 ? Mode::kPaper : Mode::kGraph;
  options.tracker.life.second_pass = byte(10) % 2 == 0;
  const Scene scene = MakeScene(scene_options);
  ObservationTruth truth;
  const DetectionSequence detections = Observe(scene, noise, &truth);
  RunRequest request;
  request.cameras = scene.cameras;
  const TrackSequence tracks = TrackSequenceOf(options, request, detections);
  int64_t last = -1;
  for (const TrackFrame& frame : tracks.frames) {
    if (frame.frame <= last) std::abort();
    last = frame.frame;
    int64_t last_id = -1;
    for (const PersonPose& person : frame.people) {
      if (person.id.value() <= last_id) std::abort();
      last_id = person.id.value();
      for (const Joint3d& joint : person.joints) {
        if (joint.present() && !joint.position_m.allFinite()) std::abort();
      }
    }
  }
  return true;
}

// Whether the page's data can be made from the input. They must then be JSON
// that cannot close the script element in which the page contains them.
bool MakesPage(const PageInput& input) {
  return Accepts([&] {
    const PageData data = MakePageData(input);
    if (!nlohmann::json::accept(data.json)) std::abort();
    if (data.json.find("</") != std::string::npos) std::abort();
  });
}

// A few frames of a person with arbitrary names and positions.
bool FuzzPage(const std::string& bytes) {
  size_t at = 0;
  const auto byte = [&] {
    return at < bytes.size() ? static_cast<uint8_t>(bytes[at++]) : uint8_t{0};
  };
  const auto text = [&] {
    std::string letters(byte() % 24, ' ');
    for (char& letter : letters) letter = static_cast<char>(byte() & 0x7f);
    return letters;
  };
  const auto number = [&] {
    double value = 0.0;
    for (size_t i = 0; i < sizeof(value); ++i) {
      reinterpret_cast<uint8_t*>(&value)[i] = byte();
    }
    return std::isfinite(value) ? value : 0.0;
  };
  PageInput input;
  input.title = text();
  PageResult& result = input.results.emplace_back();
  result.label = text();
  result.tracks.header.skeleton =
      Skeleton(text(), {"a" + text(), "b" + text()}, {{0, 1}});
  result.tracks.header.frame_rate_hz = 25.0;
  result.names[TrackId(1)] = text();
  const int frames = byte() % 4;
  for (int f = 0; f <= frames; ++f) {
    TrackFrame& frame = result.tracks.frames.emplace_back();
    frame.frame = f;
    frame.time = f * 40000000LL;
    PersonPose& person = frame.people.emplace_back();
    person.id = TrackId(byte() % 3);
    for (int j = 0; j < 2; ++j) {
      Joint3d& joint = person.joints.emplace_back();
      joint.status = static_cast<JointStatus>(byte() % 3);
      for (int k = 0; k < 3; ++k) joint.position_m[k] = number();
    }
  }
  return MakesPage(input);
}

// A page of one result with these side files.
bool FuzzSideFiles(const std::string& summary, const std::string& doctor) {
  PageInput input;
  PageResult& result = input.results.emplace_back();
  result.tracks.header.skeleton = Skeleton("one", {"nose"}, {});
  result.tracks.frames.emplace_back();
  result.summary_json = summary;
  input.doctor_json = doctor;
  return MakesPage(input);
}

}  // namespace

std::vector<FuzzTarget> RunTargets() {
  return {{"scene", FuzzScene},
          {"page", FuzzPage},
          {"summary",
           [](const std::string& bytes) { return FuzzSideFiles(bytes, ""); }},
          {"doctor",
           [](const std::string& bytes) { return FuzzSideFiles("", bytes); }},
          OfReader("configuration", [](const std::string& path) {
            ReadRunOptions(path, "", "");
          })};
}

}  // namespace kinegraph::testing
