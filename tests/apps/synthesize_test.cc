// The program kinegraph-synthesize.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <string>

#include "core/io/calibration/calibration.h"
#include "core/io/detections/source.h"
#include "core/io/tracks/tracks.h"
#include "core/io/tracks/writer.h"
#include "tests/apps/command.h"

namespace kinegraph::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

// A flag in single quotes; empty without a value.
std::string Flag(const std::string& name, const std::string& value) {
  return value.empty() ? "" : " '--" + name + "=" + value + "'";
}

constexpr const char* kFiles[] = {"cameras.json", "detections.jsonl",
                                  "truth.jsonl", "scene.json"};

class SynthesizeTest : public CommandTest {
 protected:
  std::string Flags(const std::string& config, const std::string& out,
                    const std::string& set = "",
                    const std::string& motion = "") const {
    return Flag("config", config) + Flag("motion", motion) + Flag("set", set) +
           Flag("out", Path(out));
  }
  ProgramOutcome Run(const std::string& config, const std::string& out,
                     const std::string& set = "",
                     const std::string& motion = "") const {
    return Done("synthesize", Flags(config, out, set, motion));
  }
  void ExpectSameFiles(const std::string& a, const std::string& b) const {
    for (const char* name : kFiles) {
      const std::string content = ContentOf(Path(a) + "/" + name);
      EXPECT_FALSE(content.empty());
      EXPECT_EQ(content, ContentOf(Path(b) + "/" + name)) << name;
    }
  }
  // Simulates a scene with one person and returns the path of its truth, a
  // tracks file that serves as a clip.
  std::string MakeClip() const {
    Run(folder_.Write(
            "clip.toml",
            "[scene]\nseed = 4\npeople = 1\nduration = 3\nframe_rate = 30\n"
            "[scene.motion]\nvisitors = 0.0\n"),
        "clip");
    return Path("clip/truth.jsonl");
  }
};

class ConfigFiles : public SynthesizeTest,
                    public ::testing::WithParamInterface<const char*> {};

TEST_P(ConfigFiles, OutputsAreReadByTheReaders) {
  const ProgramOutcome outcome =
      Run(ProjectFile(std::string("configs/synthetic/") + GetParam()),
          "new/scene", "scene.duration=1");
  EXPECT_EQ(outcome.errors, "");
  const fs::path out = Path("new/scene");
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
  EXPECT_THAT(scene, HasSubstr("\"duration\":1"));
  for (const auto& entry : fs::directory_iterator(out)) {
    EXPECT_THAT(kFiles, ::testing::Contains(entry.path().filename().string()))
        << "an unexpected file";
  }
}

INSTANTIATE_TEST_SUITE_P(Synthetic, ConfigFiles,
                         ::testing::Values("demo.toml", "hard.toml",
                                           "correlated_25hz.toml",
                                           "correlated_60hz.toml",
                                           "correlated_120hz.toml"));

TEST_F(SynthesizeTest, SameConfigurationSameBytes) {
  const std::string config = ProjectFile("configs/synthetic/demo.toml");
  Run(config, "a", "scene.duration=2");
  Run(config, "b", "scene.duration=2");
  Run(config, "c", "scene.duration=2;noise.seed=99");
  ExpectSameFiles("a", "b");
  EXPECT_NE(ContentOf(Path("a/detections.jsonl")),
            ContentOf(Path("c/detections.jsonl")));
}

TEST_F(SynthesizeTest, BadInputGivesOneLineAndExitCodeTwo) {
  const std::map<std::string, std::string> cases = {
      {"[scene]\npeeple = 3\n", ":2: key 'scene.peeple'"},
      {"[scene]\npeople = 0\n", ":2: key 'scene.people'"},
      {"[scene]\nskeleton = \"octopus\"\n", "scene.skeleton"},
      {"[scene.cameras]\nradius = 2.0\n", ":2: key 'scene.cameras.radius'"},
      {"[noise]\nstatic_share = 0.9\nwhite_share = 0.9\n",
       ":2: key 'noise.static_share'"},
      {"[noise]\nclock_offset = [0, 0, 0, 0, 0, 0, 0]\n",
       ":2: key 'noise.clock_offset'"},
      {"[noise.model]\nfile = \"none.json\"\n",
       ":2: key 'noise.model.file': was removed: specify the detector's "
       "errors"},
      {"[scene]\nseed = 1\n[motion]\nhold = [2]\n",
       "bad.toml:4: key 'motion.hold'"},
      {"[scene\n", ""}};
  for (const auto& [text, expected] : cases) {
    const std::string config = folder_.Write("bad.toml", text);
    EXPECT_THAT(Refusal("synthesize", Flags(config, "out")),
                HasSubstr(expected));
    EXPECT_FALSE(fs::exists(Path("out"))) << text;
  }
  const std::string good =
      folder_.Write("good.toml", "[scene]\nduration = 1\n");
  Refusal("synthesize", Flags(good, "good.toml"));  // a file is not a folder
}

// A folder of detections is never replaced, so neither are the other files.
TEST_F(SynthesizeTest, AnExistingDetectionsFolderLeavesTheEarlierScene) {
  const std::string config =
      folder_.Write("one.toml", "[scene]\nduration = 0.4\npeople = 1\n");
  const std::string as = Flag("format", "openpose");
  Done("synthesize", Flags(config, "out") + as);
  Run(config, "before");
  EXPECT_THAT(Refusal("synthesize", Flags(config, "out", "scene.seed=77") + as),
              HasSubstr("detections_openpose: exists already"));
  ExpectSameFiles("before", "out");
}

TEST_F(SynthesizeTest, HelpListsConfigAsOptional) {
  const std::string help = Done("synthesize", "--help").output;
  EXPECT_GT(help.find("  --config  ("), help.find("\nOptional:\n"));
  EXPECT_LT(help.find("  --out  ("), help.find("\nOptional:\n"));
}

TEST_F(SynthesizeTest, TakesRateAndLengthFromTheClip) {
  const std::string clip = MakeClip();
  Run("", "out", "", clip);
  const TrackSequence before = ReadTracks(clip);
  const TrackSequence truth = ReadTracks(Path("out/truth.jsonl"));
  EXPECT_EQ(truth.header.frame_rate_hz, 30.0);
  ASSERT_EQ(truth.frames.size(), before.frames.size());
  for (const TrackFrame& frame : truth.frames) {
    EXPECT_EQ(frame.people.size(), 1u) << frame.frame;
  }
  EXPECT_THAT(ContentOf(Path("out/scene.json")), HasSubstr("\"clip_id\": 0"));
}

TEST_F(SynthesizeTest, AppliesConfiguredRateStartsAndHolds) {
  const std::string clip = MakeClip();
  const std::string config =
      folder_.Write("two.toml",
                    "[scene]\nframe_rate = 60\n[scene.motion]\n"
                    "area_radius = 5.0\n"
                    "[motion]\nclips = [\"clip/truth.jsonl\", "
                    "\"clip/truth.jsonl\"]\nstart = [0, 1]\nhold = [0, 2]\n");
  Run(config, "a");  // clips are found beside the configuration
  Run(config, "b");
  ExpectSameFiles("a", "b");
  const TrackSequence truth = ReadTracks(Path("a/truth.jsonl"));
  EXPECT_EQ(truth.header.frame_rate_hz, 60.0);
  // The clip's 89 intervals of 1/30 s after 1 s and a hold of 2 s; the start
  // from rest adds 0.15 s.
  EXPECT_EQ(truth.frames.size(), 189u + 178u + 1u);
  EXPECT_EQ(truth.frames[30].people.size(), 1u);
  EXPECT_EQ(truth.frames[90].people.size(), 2u);
  // Clips of the command line take precedence: then there are two starts for
  // one clip.
  Refusal("synthesize", Flags(config, "c", "scene.seed=3", clip));
}

// The scene has the joints of the clip, unless scene.skeleton is set.
TEST_F(SynthesizeTest, ClipsWithoutFacesGiveATruthWithoutFaces) {
  TrackSequence clip = ReadTracks(MakeClip());
  std::vector<std::string> joints(clip.header.skeleton.joints().begin() + 5,
                                  clip.header.skeleton.joints().end());
  clip.header.skeleton = Skeleton("limbs", joints, {});
  for (TrackFrame& frame : clip.frames) {
    for (PersonPose& person : frame.people) {
      person.joints.erase(person.joints.begin(), person.joints.begin() + 5);
      person.inlier_views.clear();
      person.covariances.clear();
      person.matches.clear();
    }
  }
  WriteTracks(Path("limbs.jsonl"), clip);
  Run("", "limbs", "", Path("limbs.jsonl"));
  const TrackSequence truth = ReadTracks(Path("limbs/truth.jsonl"));
  EXPECT_EQ(truth.header.skeleton.name(), "coco17_part");
  EXPECT_EQ(truth.header.skeleton.joints(), joints);
  EXPECT_EQ(truth.header.skeleton.bones().size(), 12u);  // without the face
  EXPECT_EQ(truth.frames.size(), clip.frames.size());
  EXPECT_THAT(Refusal("synthesize", Flags("", "out", "scene.skeleton=coco17",
                                          Path("limbs.jsonl"))),
              HasSubstr("has no joint 'nose'"));
}

TEST_F(SynthesizeTest, ReadsOpticalMarkersAsAClip) {
  KINEGRAPH_DATA_OR_SKIP(data, "markers/qualisys_theia/dynamic_1_markers.c3d");
  Run("", "markers", "", data);
  const TrackSequence truth = ReadTracks(Path("markers/truth.jsonl"));
  EXPECT_GT(truth.header.skeleton.IndexOf("l_knee"), -1);
  EXPECT_EQ(truth.header.skeleton.IndexOf("nose"), -1);
  EXPECT_EQ(truth.header.frame_rate_hz, 200.0);
}

TEST_F(SynthesizeTest, BadClipsGiveOneLineAndExitCodeTwo) {
  const std::string clip = MakeClip();
  const std::string header =
      ContentOf(clip).substr(0, ContentOf(clip).find('\n'));
  const std::string empty = folder_.Write("empty.jsonl", header + "\n");
  const std::string rubbish = folder_.Write("rubbish.jsonl", "not tracks\n");
  const std::string hips = folder_.Write(
      "hips.jsonl",
      R"({"kinegraph": 1, "units": {"length": "m", "time": "s"}, )"
      R"("skeleton": {"name": "two", "joints": ["l_hip", "r_hip"], )"
      R"("bones": []}, "mode": "graph", "frame_rate": 30.0, "config": {}})"
      "\n"
      R"({"frame":0,"time":0.0,"people":[{"id":0,"joints":[[0,0,1],[0,1,1]],)"
      R"("status":["observed","observed"]}]})"
      "\n");
  const std::map<std::string, std::string> cases = {
      {Path("none.jsonl"), "none.jsonl"},
      {empty, "empty.jsonl: no frames"},
      {rubbish, "rubbish.jsonl"},
      {hips, "hips.jsonl: skeleton 'two' has no joint 'nose'"},
      {clip + ",", "--motion"}};
  for (const auto& [motion, expected] : cases) {
    EXPECT_THAT(Refusal("synthesize", Flags("", "out", "", motion)),
                HasSubstr(expected));
    EXPECT_FALSE(fs::exists(Path("out"))) << motion;
  }
}

TEST_F(SynthesizeTest, RunsShippedConfigurationsOnRecordedClips) {
  KINEGRAPH_DATA_OR_SKIP(data, "motion/walk_30hz.jsonl");
  const std::string clips = fs::path(data).parent_path().string() + "/";
  for (const std::string name : {"motion.toml", "motion_after_rest.toml"}) {
    Run(ProjectFile("configs/synthetic/" + name), "one_" + name, "", data);
  }
  Run(ProjectFile("configs/synthetic/motion_crowd.toml"), "crowd", "",
      data + "," + clips + "dance_30hz.jsonl," + clips + "hop_30hz.jsonl");
  const TrackSequence truth = ReadTracks(Path("crowd/truth.jsonl"));
  EXPECT_EQ(truth.frames[0].people.size(), 1u);
  EXPECT_EQ(truth.frames[55].people.size(), 3u);
}

}  // namespace
}  // namespace kinegraph::testing
