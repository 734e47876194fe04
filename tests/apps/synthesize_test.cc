// The program itself: files in, files out.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <string>

#include "core/io/calibration.h"
#include "core/io/detection_source.h"
#include "core/io/tracks.h"
#include "tests/support/program.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;
using testing::ContentOf;
using testing::ProgramOutcome;
using testing::ProjectFile;
using testing::RunProgram;
using testing::TemporaryFolder;

ProgramOutcome Synthesize(const TemporaryFolder& folder,
                          const std::string& config, const std::string& out,
                          const std::string& set = "") {
  return RunProgram("synthesize",
                    "'--config=" + config +
                        "' '--out=" + (folder.path() / out).string() + "'" +
                        (set.empty() ? "" : " '--set=" + set + "'"));
}

constexpr const char* kFiles[] = {"cameras.json", "detections.jsonl",
                                  "truth.jsonl", "scene.json"};

class ConfigFiles : public ::testing::TestWithParam<const char*> {};

TEST_P(ConfigFiles, MakeWhatTheReadersRead) {
  const TemporaryFolder folder;
  const std::string config =
      ProjectFile(std::string("configs/synthetic/") + GetParam()).string();
  const ProgramOutcome outcome =
      Synthesize(folder, config, "new/scene", "scene.duration=1");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_EQ(outcome.errors, "");
  const fs::path out = folder.path() / "new/scene";
  const CameraRig cameras = ReadCameras((out / "cameras.json").string());
  const DetectionSequence detections =
      ReadDetections((out / "detections.jsonl").string());
  const TrackSequence truth = ReadTracks((out / "truth.jsonl").string());
  EXPECT_GE(cameras.size(), 4u);
  EXPECT_LE(cameras.size(), 6u);
  ASSERT_EQ(detections.header.view_names.size(), cameras.size());
  ASSERT_EQ(truth.frames.size(), detections.frames.size());
  EXPECT_GE(static_cast<double>(truth.frames.size()),
            0.8 * detections.header.frame_rate_hz);
  for (size_t f = 0; f < truth.frames.size(); ++f) {
    EXPECT_EQ(truth.frames[f].frame, detections.frames[f].frame);
    EXPECT_EQ(truth.frames[f].time, detections.frames[f].time);
  }
  const std::string scene = ContentOf(out / "scene.json");
  EXPECT_THAT(scene, ::testing::HasSubstr("\"duration\":1"));
  for (const auto& entry : fs::directory_iterator(out)) {
    EXPECT_THAT(kFiles, ::testing::Contains(entry.path().filename().string()))
        << "nothing else is left";
  }
}

INSTANTIATE_TEST_SUITE_P(Synthetic, ConfigFiles,
                         ::testing::Values("demo.toml", "hard.toml",
                                           "correlated_25hz.toml",
                                           "correlated_60hz.toml",
                                           "correlated_120hz.toml"));

TEST(Synthesize, SameConfigurationSameBytes) {
  const TemporaryFolder folder;
  const std::string config = ProjectFile("configs/synthetic/demo.toml");
  const std::string set = "scene.duration=2";
  ASSERT_EQ(Synthesize(folder, config, "a", set).exit_code, 0);
  ASSERT_EQ(Synthesize(folder, config, "b", set).exit_code, 0);
  ASSERT_EQ(Synthesize(folder, config, "c", set + ";noise.seed=99").exit_code,
            0);
  for (const char* name : kFiles) {
    const std::string content = ContentOf(folder.path() / "a" / name);
    EXPECT_FALSE(content.empty());
    EXPECT_EQ(content, ContentOf(folder.path() / "b" / name)) << name;
  }
  EXPECT_NE(ContentOf(folder.path() / "a/detections.jsonl"),
            ContentOf(folder.path() / "c/detections.jsonl"));
}

TEST(Synthesize, BadInputIsOneLineAndExitTwo) {
  const TemporaryFolder folder;
  const std::map<std::string, std::string> cases = {
      {"[scene]\npeeple = 3\n", ":2: key 'scene.peeple'"},
      {"[scene]\npeople = 0\n", ":2: key 'scene.people'"},
      {"[scene]\nskeleton = \"octopus\"\n", "scene.skeleton"},
      {"[scene.cameras]\nradius = 2.0\n", ":2: key 'scene.cameras.radius'"},
      {"[noise]\nstatic_share = 0.9\nwhite_share = 0.9\n",
       ":2: key 'noise.static_share'"},
      {"[noise]\nclock_offset = [0, 0, 0, 0, 0, 0, 0]\n",
       ":2: key 'noise.clock_offset'"},
      {"[noise.model]\nfile = \"none.json\"\n", "none.json"},
      {"[scene\n", ""}};
  for (const auto& [text, expected] : cases) {
    const std::string config = folder.Write("bad.toml", text);
    const ProgramOutcome outcome = Synthesize(folder, config, "out");
    EXPECT_EQ(outcome.exit_code, 2) << text;
    EXPECT_THAT(outcome.errors, ::testing::HasSubstr(expected)) << text;
    EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'), 1)
        << outcome.errors;
    EXPECT_FALSE(fs::exists(folder.path() / "out")) << text;
  }
  const std::string good = folder.Write("good.toml", "[scene]\nduration = 1\n");
  EXPECT_EQ(Synthesize(folder, good, "good.toml").exit_code, 2)
      << "a file is no folder";
}

TEST(Synthesize, MeasuredFiguresComeFromTheModelFile) {
  KINEGRAPH_DATA_OR_SKIP(path, "campus/detections_modelled/noise_model.json");
  const TemporaryFolder folder;
  const std::string config =
      folder.Write("model.toml",
                   "[scene]\nduration = 2\n[noise]\nfalse_people = 0.0\n"
                   "[noise.model]\nmissing = 0.5\nfile = \"" +
                       fs::absolute(path).string() + "\"\n");
  const ProgramOutcome outcome = Synthesize(folder, config, "out");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  const std::string scene = ContentOf(folder.path() / "out/scene.json");
  EXPECT_THAT(scene, ::testing::HasSubstr("\"wrist\""));
  EXPECT_THAT(scene, ::testing::HasSubstr("\"false_people\":0.0"))
      << "the configuration's own keys win";
  EXPECT_THAT(scene,
              ::testing::Not(::testing::HasSubstr("\"false_positive\"")));
  // Joints' own keys would do nothing beside the model.
  EXPECT_EQ(Synthesize(folder, config, "other", "noise.sigma=3").exit_code, 2);
}

// The whole way: exact detections through the tracker give the truth back.
TEST(Synthesize, ExactDetectionsAreTrackedExactly) {
  const TemporaryFolder folder;
  const std::string scene_config =
      folder.Write("scene.toml",
                   "[scene]\nseed = 5\npeople = 3\nduration = 6\n"
                   "[scene.motion]\narea_radius = 1.6\nvisitors = 0.0\n"
                   "[scene.cameras]\ncount = 5\n"
                   "distortion = [-0.2, 0.05, 0.001, -0.001, 0.0]\n"
                   "[noise]\ndropped_frame_rate = 0.1\ntime_jitter = 0.004\n");
  ASSERT_EQ(Synthesize(folder, scene_config, "scene").exit_code, 0);
  const std::string track_config = folder.Write(
      "track.toml",
      "mode = \"paper\"\n[gaussian]\nsmooth = false\n"
      "[association]\nalpha_2d = 100.0\n[reconstruction]\nalpha_epi = 30.0\n");
  const std::string scene = (folder.path() / "scene").string();
  const std::string tracks_path = (folder.path() / "tracks.jsonl").string();
  const ProgramOutcome outcome = RunProgram(
      "track", "--cameras=" + scene + "/cameras.json --detections=" + scene +
                   "/detections.jsonl --config=" + track_config +
                   " --out=" + tracks_path);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  const DetectionSequence detections =
      ReadDetections(scene + "/detections.jsonl");
  const TrackSequence truth = ReadTracks(scene + "/truth.jsonl");
  const TrackSequence tracks = ReadTracks(tracks_path);
  EXPECT_LT(detections.frames.size(), 145u) << "some of 150 are dropped";
  // Lost frames stay lost, and the clock's jitter is in `time`.
  ASSERT_EQ(tracks.frames.size(), detections.frames.size());
  int64_t joints = 0;
  int64_t exact = 0;
  for (size_t f = 0; f < tracks.frames.size(); ++f) {
    EXPECT_EQ(tracks.frames[f].frame, detections.frames[f].frame);
    EXPECT_EQ(tracks.frames[f].time, detections.frames[f].time);
    for (const PersonPose& person : tracks.frames[f].people) {
      for (size_t j = 0; j < person.joints.size(); ++j) {
        if (person.joints[j].status != JointStatus::kObserved) continue;
        double nearest = 1e9;
        for (const PersonPose& other : truth.frames[f].people) {
          nearest = std::min(nearest, (other.joints[j].position_m -
                                       person.joints[j].position_m)
                                          .norm());
        }
        ++joints;
        exact += nearest < 1e-6 ? 1 : 0;
      }
    }
  }
  EXPECT_GT(joints, 3 * 17 * 100);
  // All: everybody is in all images, so no older view takes part.
  EXPECT_EQ(exact, joints);
}

}  // namespace
}  // namespace kinegraph
