// Inputs that once failed, replayed, and a few seeded mutations of good ones,
// so that every build is tried a little. The hours are libFuzzer's
// (docs/robustness.md).
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <string>

#include "core/base/random.h"
#include "core/io/calibration_writer.h"
#include "core/io/detection_writer.h"
#include "core/io/track_export.h"
#include "core/io/track_writer.h"
#include "core/synthetic/noise.h"
#include "core/synthetic/scene.h"
#include "tests/fuzz/targets.h"
#include "tests/support/mat_file.h"
#include "tests/support/program.h"
#include "tests/support/test_data.h"

namespace kinegraph::testing {
namespace {

namespace fs = std::filesystem;

void TryInput(const FuzzTarget& target, const std::string& input) {
  target.run(reinterpret_cast<const uint8_t*>(input.data()), input.size());
}

class ReplayTest : public ::testing::TestWithParam<FuzzTarget> {};

// Each was chosen because it once took memory, time or the program.
TEST_P(ReplayTest, InputsThatOnceFailed) {
  const fs::path folder =
      ProjectFile("tests/fuzz/regressions") / GetParam().name;
  int count = 0;
  if (fs::is_directory(folder)) {
    for (const auto& entry : fs::directory_iterator(folder)) {
      SCOPED_TRACE(entry.path().filename().string());
      const auto start = std::chrono::steady_clock::now();
      TryInput(GetParam(), ContentOf(entry.path()));
      // They took from ten seconds to for ever; now milliseconds.
      EXPECT_LT(std::chrono::steady_clock::now() - start,
                std::chrono::seconds(5));
      ++count;
    }
  }
  RecordProperty("inputs", count);
}

std::string Mutated(std::string input, Random* random) {
  const int64_t changes = 1 + random->Index(4);
  for (int64_t c = 0; c < changes && !input.empty(); ++c) {
    const auto size = static_cast<int64_t>(input.size());
    const auto at = static_cast<size_t>(random->Index(size));
    switch (random->Index(4)) {
      case 0:
        input[at] = static_cast<char>(random->Index(256));
        break;
      case 1:
        input.erase(at, static_cast<size_t>(1 + random->Index(16)));
        break;
      case 2:
        input.insert(at, input.substr(static_cast<size_t>(random->Index(size)),
                                      static_cast<size_t>(random->Index(32))));
        break;
      default: {
        static constexpr const char* kWords[] = {
            ",",  "[", "{", "\"", "null", "-1", "1e400", "99999999999999999999",
            "\n", "0"};
        input.insert(at, kWords[random->Index(10)]);
      }
    }
  }
  return input;
}

// Good inputs of each reader, from the project's own writers.
std::vector<std::string> SeedsOf(const std::string& target) {
  const TemporaryFolder folder;
  const std::string path = (folder.path() / "seed").string();
  SceneOptions options;
  options.people = 1;
  options.motion.visitors = 0.0;  // there from the first frame on
  options.duration_s = 0.12;
  const Scene scene = MakeScene(options);
  ObservationTruth truth;
  const DetectionSequence detections = Observe(scene, NoiseOptions(), &truth);
  const TrackSequence tracks = TruthOf(scene);
  Losses losses;
  std::vector<std::string> seeds;
  const auto keep = [&] { seeds.push_back(ContentOf(path)); };
  if (target == "calibration") {
    for (const CalibrationFormat format :
         {CalibrationFormat::kKinegraph, CalibrationFormat::kPose2sim,
          CalibrationFormat::kPanoptic}) {
      WriteCalibration(path, format, scene.cameras, &losses);
      keep();
    }
    seeds.push_back(
        "%YAML:1.0\n---\nnames:\n  - \"0\"\nK_0: !!opencv-matrix\n  rows: 3\n"
        "  cols: 3\n  dt: d\n  data: [1000, 0, 500, 0, 1000, 500, 0, 0, 1]\n"
        "dist_0: !!opencv-matrix\n  rows: 1\n  cols: 5\n  dt: d\n"
        "  data: [0, 0, 0, 0, 0]\n");
  } else if (target == "detections") {
    WriteDetections(path, detections);
    keep();
  } else if (target == "tracks") {
    WriteTracks(path, tracks);
    keep();
    WriteTracksCsv(path, tracks, &losses);
    keep();
    WriteTracks4dAssociation(path, tracks, &losses);
    keep();
  } else if (target == "npz") {
    WriteTracksNpz(path, tracks, &losses);
    keep();
  } else if (target == "mat") {
    WriteTracksTum(path, tracks, &losses);
    keep();
  } else if (target == "configuration") {
    seeds.push_back(ContentOf(ProjectFile("configs/graph/offline.toml")));
    seeds.push_back(ContentOf(ProjectFile("configs/paper/shelf.toml")));
  } else if (target == "manifest") {
    seeds.emplace_back(
        "report = true\n[[takes]]\nname = \"a\"\ncameras = \"c\"\n"
        "detections = \"d\"\n[[configurations]]\nname = \"b\"\n"
        "config = \"e.toml\"\n");
  } else if (target == "held_out_set") {
    seeds.emplace_back(
        R"({"min_confidence": 0.3, "pairing_gate_m": 0.5, "cap_px": 100,)"
        R"( "views": ["a"], "detections": [{"frame": 3, "view": 0,)"
        R"( "detection": 0, "person": 1}]})");
  } else {
    seeds.emplace_back("\x01\x02\x80\x02\x03\x40\x40\x40\x40\x01\x01", 11);
  }
  return seeds;
}

TEST_P(ReplayTest, MutationsOfGoodInputs) {
  const std::string name = GetParam().name;
  const int count = name == "scene" ? 3 : 150;
  Random random(1);
  for (const std::string& seed : SeedsOf(name)) {
    ASSERT_FALSE(seed.empty());
    TryInput(GetParam(), seed);
    for (int i = 0; i < count; ++i) {
      TryInput(GetParam(), Mutated(seed, &random));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Every, ReplayTest, ::testing::ValuesIn(FuzzTargets()),
                         [](const ::testing::TestParamInfo<FuzzTarget>& test) {
                           return std::string(test.param.name);
                         });

}  // namespace
}  // namespace kinegraph::testing
