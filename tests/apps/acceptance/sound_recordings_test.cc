// `track` without a configuration gives no warnings for good recordings, and
// warnings if cameras have errors.
// tests/solvers/session/recording_report_test.cc has ten faulty set-ups.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "tests/apps/command.h"

namespace kinegraph {
namespace {

using testing::Done;
using ::testing::HasSubstr;
using testing::ProgramOutcome;

// The warnings of a run, as printed and as in the summary.
std::string WarningsOf(const std::string& arguments) {
  const testing::TemporaryFolder folder;
  const ProgramOutcome outcome = Done(
      "track", arguments + " --out='" + folder.path().string() + "/t.jsonl'");
  const auto summary = nlohmann::json::parse(
      testing::ContentOf(folder.path() / "t.summary.json"));
  EXPECT_GT(summary.at("poses").get<int>(), 0);
  // The output also contains progress.
  const size_t said = outcome.errors.find("warning");
  std::string warnings =
      said == std::string::npos ? "" : outcome.errors.substr(said);
  for (const auto& warning : summary.at("warnings")) {
    warnings += warning.at("kind").get<std::string>() + ": " +
                warning.at("text").get<std::string>() + "\n";
  }
  return warnings;
}

TEST(SoundRecordings, ShelfGivesNoWarnings) {
  KINEGRAPH_DATA_OR_SKIP(data, "shelf/detections/openpose");
  EXPECT_EQ(WarningsOf("--cameras='" + data +
                       "/../../calibration.json' --detections='" + data +
                       "' --set=input.frame_rate=25 --frames=300:600"),
            "");
}

TEST(SoundRecordings, CampusGivesNoWarnings) {
  KINEGRAPH_DATA_OR_SKIP(data, "campus/calibration.json");
  const std::string folder = testing::FindData("campus")->string();
  EXPECT_EQ(WarningsOf(
                "--cameras='" + data + "' --detections='" + folder +
                "/detections_modelled/typical' --set='input.frame_rate=25;"
                "cameras.image_size=[360,288];cameras.ignore_distortion=true'"),
            "");
}

TEST(SoundRecordings, SingleIndependentFrameGivesNoWarnings) {
  KINEGRAPH_DATA_OR_SKIP(data, "shelf/calibration.json");
  EXPECT_EQ(WarningsOf("--cameras='" + data + "' --detections='" +
                       testing::FindData("shelf")->string() +
                       "/detections/openpose' --frames=400:401 --set='"
                       "input.frame_rate=25;input.independent_frames=true'"),
            "");
}

TEST(SoundRecordings, DisplacedCamerasGiveAWarning) {
  for (const std::string trial : {"single", "multi"}) {
    KINEGRAPH_DATA_OR_SKIP(data, "pose2sim/" + trial + "/pose");
    const std::string calibration =
        testing::FindData("pose2sim/calibration/Calib.toml")->string();
    EXPECT_THAT(WarningsOf("--cameras='" + calibration + "' --detections='" +
                           data + "' --set=input.frame_rate=60"),
                HasSubstr("cam"))
        << trial;
  }
}

class SoundScenes : public ::testing::TestWithParam<const char*> {};

TEST_P(SoundScenes, GiveNoWarnings) {
  const testing::TemporaryFolder folder;
  const std::string scene = folder.path().string() + "/scene";
  Done("synthesize",
       "--config='" + testing::ProjectFile("configs/synthetic").string() + "/" +
           GetParam() + ".toml' --set=scene.duration=4 --out='" + scene + "'");
  EXPECT_EQ(WarningsOf("--cameras='" + scene + "/cameras.json' --detections='" +
                       scene + "/detections.jsonl'"),
            "");
}

INSTANTIATE_TEST_SUITE_P(Scenes, SoundScenes,
                         ::testing::Values("demo", "hard", "long",
                                           "correlated_25hz", "correlated_60hz",
                                           "correlated_120hz"),
                         [](const auto& scene) {
                           return std::string(scene.param);
                         });

}  // namespace
}  // namespace kinegraph
