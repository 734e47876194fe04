// The program itself: files in, files out.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <string>

#include "core/io/calibration/calibration.h"
#include "core/io/detections/source.h"
#include "core/io/tracks/tracks.h"
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

// A clip: somebody of a simulated scene, whose truth is a tracks file.
std::string MakeClip(const TemporaryFolder& folder) {
  const std::string config = folder.Write(
      "clip.toml",
      "[scene]\nseed = 4\npeople = 1\nduration = 3\nframe_rate = 30\n"
      "[scene.motion]\nvisitors = 0.0\n");
  EXPECT_EQ(Synthesize(folder, config, "clip").exit_code, 0);
  return (folder.path() / "clip/truth.jsonl").string();
}

ProgramOutcome SynthesizeMotion(const TemporaryFolder& folder,
                                const std::string& motion,
                                const std::string& more,
                                const std::string& out) {
  return RunProgram("synthesize",
                    "'--motion=" + motion + "' " + more +
                        " '--out=" + (folder.path() / out).string() + "'");
}

TEST(SynthesizeMotion, TakesRateAndLengthFromTheClipAlone) {
  const TemporaryFolder folder;
  const std::string clip = MakeClip(folder);
  ASSERT_EQ(SynthesizeMotion(folder, clip, "", "out").exit_code, 0);
  const TrackSequence before = ReadTracks(clip);
  const TrackSequence truth =
      ReadTracks((folder.path() / "out/truth.jsonl").string());
  EXPECT_EQ(truth.header.frame_rate_hz, 30.0);
  ASSERT_EQ(truth.frames.size(), before.frames.size());
  for (const TrackFrame& frame : truth.frames) {
    EXPECT_EQ(frame.people.size(), 1u) << frame.frame;
  }
  EXPECT_THAT(ContentOf(folder.path() / "out/scene.json"),
              ::testing::HasSubstr("\"clip_id\": 0"));
}

TEST(SynthesizeMotion, ConfigurationRateStartsAndHoldsCount) {
  const TemporaryFolder folder;
  const std::string clip = MakeClip(folder);
  const std::string config =
      folder.Write("two.toml",
                   "[scene]\nframe_rate = 60\n[scene.motion]\n"
                   "area_radius = 5.0\n"
                   "[motion]\nclips = [\"clip/truth.jsonl\", "
                   "\"clip/truth.jsonl\"]\nstart = [0, 1]\nhold = [0, 2]\n");
  ASSERT_EQ(Synthesize(folder, config, "a").exit_code, 0)
      << "clips are found beside the configuration";
  ASSERT_EQ(Synthesize(folder, config, "b").exit_code, 0);
  for (const char* name : kFiles) {
    EXPECT_EQ(ContentOf(folder.path() / "a" / name),
              ContentOf(folder.path() / "b" / name))
        << name;
  }
  const TrackSequence truth =
      ReadTracks((folder.path() / "a/truth.jsonl").string());
  EXPECT_EQ(truth.header.frame_rate_hz, 60.0);
  // The clip's 89 intervals of 1/30 s after 1 s and a hold of 2 s, whose start
  // from rest takes 0.15 s more.
  EXPECT_EQ(truth.frames.size(), 189u + 178u + 1u);
  EXPECT_EQ(truth.frames[30].people.size(), 1u);
  EXPECT_EQ(truth.frames[90].people.size(), 2u);
  // The command line's clips win.
  ASSERT_EQ(
      SynthesizeMotion(folder, clip,
                       "'--config=" + config + "' '--set=scene.seed=3'", "c")
          .exit_code,
      2)
      << "two starts for one clip";
}

TEST(SynthesizeMotion, BadClipsAreOneLineAndExitTwo) {
  const TemporaryFolder folder;
  const std::string clip = MakeClip(folder);
  const std::string header =
      ContentOf(clip).substr(0, ContentOf(clip).find('\n'));
  const std::string empty = folder.Write("empty.jsonl", header + "\n");
  const std::string rubbish = folder.Write("rubbish.jsonl", "not tracks\n");
  const std::string hips = folder.Write(
      "hips.jsonl",
      R"({"kinegraph": 1, "units": {"length": "m", "time": "s"}, )"
      R"("skeleton": {"name": "two", "joints": ["l_hip", "r_hip"], )"
      R"("bones": []}, "mode": "graph", "frame_rate": 30.0, "config": {}})"
      "\n"
      R"({"frame":0,"time":0.0,"people":[{"id":0,"joints":[[0,0,1],[0,1,1]],)"
      R"("status":["observed","observed"]}]})"
      "\n");
  const std::map<std::string, std::string> cases = {
      {(folder.path() / "none.jsonl").string(), "none.jsonl"},
      {empty, "empty.jsonl: no frames"},
      {rubbish, "rubbish.jsonl"},
      {hips, "hips.jsonl: skeleton 'two' has no joint 'nose'"},
      {clip + ",", "--motion"}};
  for (const auto& [motion, expected] : cases) {
    const ProgramOutcome outcome = SynthesizeMotion(folder, motion, "", "out");
    EXPECT_EQ(outcome.exit_code, 2) << motion;
    EXPECT_THAT(outcome.errors, ::testing::HasSubstr(expected));
    EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'), 1)
        << outcome.errors;
    EXPECT_FALSE(fs::exists(folder.path() / "out")) << motion;
  }
  const std::string config =
      folder.Write("hold.toml", "[scene]\nseed = 1\n[motion]\nhold = [2]\n");
  const ProgramOutcome outcome = Synthesize(folder, config, "out");
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.errors,
              ::testing::HasSubstr("hold.toml:4: key 'motion.hold'"));
}

TEST(SynthesizeMotion, RecordedClipsAreSeenAsTheyAre) {
  KINEGRAPH_DATA_OR_SKIP(data, "motion/walk_30hz.jsonl");
  const std::string folder_of_data = fs::path(data).parent_path().string();
  const TemporaryFolder folder;
  for (const char* name : {"motion.toml", "motion_after_rest.toml"}) {
    const std::string config =
        ProjectFile(std::string("configs/synthetic/") + name).string();
    const ProgramOutcome outcome = SynthesizeMotion(
        folder, data, "'--config=" + config + "'", std::string("one_") + name);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
  }
  const std::string config = ProjectFile("configs/synthetic/motion_crowd.toml");
  const std::string clips = data + "," + folder_of_data + "/dance_30hz.jsonl," +
                            folder_of_data + "/hop_30hz.jsonl";
  const ProgramOutcome outcome =
      SynthesizeMotion(folder, clips, "'--config=" + config + "'", "crowd");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  const TrackSequence truth =
      ReadTracks((folder.path() / "crowd/truth.jsonl").string());
  EXPECT_EQ(truth.frames[0].people.size(), 1u);
  EXPECT_EQ(truth.frames[55].people.size(), 3u);
}

}  // namespace
}  // namespace kinegraph
