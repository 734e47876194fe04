// A new user's way with a recording of their own: init, track, report, without
// any configuration written by hand. The recordings are synthetic, their
// detector is modelled noise.
#include "tests/support/own_recording.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "core/io/calibration/calibration.h"
#include "core/io/calibration/format.h"
#include "core/io/tracks/tracks.h"
#include "solvers/session/options.h"
#include "tests/support/faulty_scene.h"
#include "tests/support/opensim_trc.h"
#include "tests/support/program.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using testing::ContentOf;
using ::testing::HasSubstr;
using testing::OwnRecording;
using testing::ProgramOutcome;
using testing::ProjectFile;
using testing::RunProgram;
using testing::TemporaryFolder;

ProgramOutcome Expect0(const std::string& command,
                       const std::string& arguments) {
  ProgramOutcome outcome = RunProgram(command, arguments);
  EXPECT_EQ(outcome.exit_code, 0) << command << ": " << outcome.errors;
  return outcome;
}

class OwnRecordings : public ::testing::TestWithParam<OwnRecording> {};

TEST_P(OwnRecordings, NeedNoConfigurationByHand) {
  const OwnRecording& recording = GetParam();
  const TemporaryFolder folder;
  const testing::OwnRecordingOutcome outcome =
      testing::WalkFiveSteps(recording, folder.path().string());
  ASSERT_EQ(outcome.failed, "");
  EXPECT_THAT(outcome.init,
              HasSubstr("skeleton    " + recording.skeleton + ","));
  EXPECT_THAT(outcome.init, HasSubstr("unit        " + recording.unit() + ":"));
  EXPECT_THAT(outcome.init, ::testing::Not(HasSubstr("warning")));
  EXPECT_THAT(outcome.track, ::testing::Not(HasSubstr("warning")));
  const auto summary =
      nlohmann::json::parse(ContentOf(folder.path() / "take.summary.json"));
  EXPECT_EQ(summary.at("people").size(), static_cast<size_t>(recording.people));
  EXPECT_TRUE(summary.at("warnings").empty());
  EXPECT_EQ(outcome.identity.switches, 0);
  EXPECT_EQ(outcome.identity.identities, recording.people);
  EXPECT_LE(outcome.error_m, 1.05 * outcome.by_hand_error_m);
  // 4 px of 800 are 32 mm across at 6.5 m, seen by several cameras.
  EXPECT_LT(outcome.error_m, 0.032 * recording.radius_m() / 6.5);
  EXPECT_THAT(ContentOf(folder.path() / "page/take.html"),
              HasSubstr("kinegraph_summary"));
}

INSTANTIATE_TEST_SUITE_P(
    FiveSteps, OwnRecordings,
    ::testing::ValuesIn(testing::CoveringRecordings()),
    [](const ::testing::TestParamInfo<OwnRecording>& test) {
      return test.param.name();
    });

// One person for two seconds.
OwnRecording SmallRecording(const std::string& format,
                            const std::string& skeleton) {
  OwnRecording recording;
  recording.format = format;
  recording.skeleton = skeleton;
  recording.people = 1;
  return recording;
}

TEST(OwnRecording, TellsWhatIsMissingOrWrong) {
  const TemporaryFolder folder;
  const std::string in = folder.path().string();
  const OwnRecording recording = SmallRecording("openpose", "body25");
  testing::MakeOwnRecording(recording, in);
  const std::string what = "--cameras='" + in + "/cameras.json' " +
                           "--detections='" + in + "/detections_openpose' ";
  const ProgramOutcome no_rate =
      RunProgram("init", what + "--out='" + in + "/my.toml'");
  EXPECT_EQ(no_rate.exit_code, 2);
  EXPECT_THAT(no_rate.errors, HasSubstr("never guessed"));
  EXPECT_EQ(ContentOf(folder.path() / "my.toml"), "");
  const ProgramOutcome track =
      RunProgram("track", what + "--out='" + in + "/take.jsonl'");
  EXPECT_EQ(track.exit_code, 2);
  EXPECT_THAT(track.errors, HasSubstr("input.frame_rate"));
  const ProgramOutcome extension = RunProgram(
      "track", what + "--set=input.frame_rate=25 --out='" + in + "/take.xyz'");
  EXPECT_EQ(extension.exit_code, 2);
  EXPECT_THAT(extension.errors,
              HasSubstr("must end in .jsonl, .csv, .npz, .trc"));
}

TEST(OwnRecording, InitKeepsWhatItIsTold) {
  const TemporaryFolder folder;
  const std::string in = folder.path().string();
  const OwnRecording recording = SmallRecording("coco", "coco17");
  testing::MakeOwnRecording(recording, in);
  Expect0("init",
          "--cameras='" + in + "/cameras.json' --detections='" + in +
              "/detections.jsonl' --set='cameras.ignore_distortion=true; "
              "mode=graph;tracking.max_gap_s=0.2;output.observations=true;"
              "cameras.map.cam0=cam0;cameras.use=[cam0,cam1,cam2,cam3];"
              "input.frame_rate=25' --out='" +
              in + "/my.toml'");
  const RunOptions options = ReadRunOptions(in + "/my.toml", "", "");
  EXPECT_TRUE(options.cameras.ignore_distortion);
  EXPECT_EQ(options.tracker.life.max_gap_s, 0.2);
  EXPECT_EQ(options.cameras.map.at("cam0"), "cam0");
  EXPECT_EQ(options.cameras.use.size(), 4u);
  EXPECT_EQ(options.input.frame_rate_hz, 25.0);
  EXPECT_EQ(options.estimators.output, OutputKind::kBatch);
  const ProgramOutcome unknown = RunProgram(
      "init", "--cameras='" + in + "/cameras.json' --detections='" + in +
                  "/detections.jsonl' --set=cameras.unti=mm --out='" + in +
                  "/x.toml'");
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_THAT(unknown.errors, HasSubstr("cameras.unit"));
}

// `detections` with the pictures of view "cam1" so many frames late.
std::string WithLateView(const std::string& detections, size_t frames_late) {
  std::istringstream lines(detections);
  std::string header;
  std::getline(lines, header);
  std::vector<nlohmann::json> frames;
  for (std::string line; std::getline(lines, line);) {
    frames.push_back(nlohmann::json::parse(line));
  }
  std::string late = header + "\n";
  for (size_t k = 0; k < frames.size(); ++k) {
    nlohmann::json frame = frames[k];
    frame["views"]["cam1"] =
        frames[k - std::min(k, frames_late)]["views"]["cam1"];
    late += frame.dump() + "\n";
  }
  return late;
}

// Cameras that were bumped into, and one that started late, are refined by what
// `init` writes; a sound recording is left alone.
TEST(OwnRecording, InitHasWhatIsOffRefined) {
  const TemporaryFolder folder;
  const std::string in = folder.path().string();
  OwnRecording recording = SmallRecording("coco", "coco17");
  recording.people = 3;
  recording.duration_s = 6.0;
  testing::MakeOwnRecording(recording, in);
  CameraRig turned;
  for (const Camera& camera : ReadCameras(in + "/cameras.json")) {
    turned.push_back(testing::Turned(camera, 0.7, 21 + turned.size()));
  }
  LostFields lost_fields;
  WriteCalibration(in + "/turned.json", "krt", turned, &lost_fields);
  std::ofstream(in + "/late.jsonl")
      << WithLateView(ContentOf(folder.path() / "detections.jsonl"), 4);
  const auto written = [&](const std::string& cameras,
                           const std::string& detections) {
    const std::string out = in + "/my.toml";
    Expect0("init", "--cameras='" + in + "/" + cameras + "' --detections='" +
                        in + "/" + detections + "' --out='" + out + "'");
    return ReadRunOptions(out, "", "").refine;
  };
  const RefineOptions sound = written("cameras.json", "detections.jsonl");
  EXPECT_EQ(sound.refine, RefineKind::kOff);
  EXPECT_FALSE(sound.refine_clock);
  EXPECT_EQ(written("turned.json", "detections.jsonl").refine,
            RefineKind::kPose);
  EXPECT_TRUE(written("cameras.json", "late.jsonl").refine_clock);

  // What a calibration records of clocks is set right before anybody looks.
  Expect0("track", "--cameras='" + in + "/cameras.json' --detections='" + in +
                       "/late.jsonl' --config='" + in + "/my.toml' --out='" +
                       in + "/clocks.jsonl'");
  EXPECT_FALSE(written("clocks.cameras.json", "late.jsonl").refine_clock);

  // What was moved is what the page shows, though --cameras names the others.
  written("turned.json", "detections.jsonl");
  const std::string what = "--cameras='" + in + "/turned.json' --detections='" +
                           in + "/detections.jsonl' --config='" + in +
                           "/my.toml' ";
  Expect0("track", what + "--out='" + in + "/take.jsonl'");
  EXPECT_THAT(Expect0("report", what + "--tracks='" + in +
                                    "/take.jsonl' --out='" + in + "/take.html'")
                  .output,
              HasSubstr("moved them: " + in + "/take.cameras.json"));
}

TEST(OwnRecording, TheExtensionChoosesTheFormat) {
  const TemporaryFolder folder;
  const std::string in = folder.path().string();
  const OwnRecording recording = SmallRecording("coco", "coco17");
  testing::MakeOwnRecording(recording, in);
  const std::string what = "--cameras='" + in + "/cameras.json' " +
                           "--detections='" + in + "/detections.jsonl' ";
  size_t frames = 0;
  for (const std::string name : {"take.jsonl", "take.csv", "take.npz"}) {
    Expect0("track", what + "--out='" + in + "/sub/" + name + "'");
    const TrackSequence tracks = ReadTracks(in + "/sub/" + name);
    if (frames == 0) frames = tracks.frames.size();
    EXPECT_GT(tracks.frames.size(), 50u) << name;
    EXPECT_LE(tracks.frames.size(), frames) << name;
  }
  Expect0("track", what + "--out='" + in + "/sub/people.trc'");
  EXPECT_GT(ReadTracks(in + "/sub/people").frames.size(), 50u);
  EXPECT_TRUE(testing::OpenSimReads(in + "/sub/people"));
  EXPECT_THAT(ContentOf(folder.path() / "sub/people/person_0.trc"),
              HasSubstr("l_hip"));
  Expect0("track", what + "--markers=opensim --out='" + in + "/osim.trc'");
  EXPECT_TRUE(testing::OpenSimReads(in + "/osim"));
  EXPECT_THAT(ContentOf(folder.path() / "osim/person_0.trc"),
              HasSubstr("LHip"));
  const ProgramOutcome markers = RunProgram(
      "track", what + "--markers=opensim --out='" + in + "/x.jsonl'");
  EXPECT_EQ(markers.exit_code, 2);
  EXPECT_THAT(markers.errors, HasSubstr("--markers"));
}

TEST(OwnRecording, AnUnknownConfigurationIsAnsweredWithTheKnownOnes) {
  const ProgramOutcome outcome = RunProgram(
      "track", "--cameras=a --detections=b --config=ofline.toml --out=c.jsonl");
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.errors, HasSubstr("ofline.toml: is not there"));
  EXPECT_THAT(outcome.errors, HasSubstr("default.toml, offline.toml, graph/"));
}

}  // namespace
}  // namespace kinegraph
