// A new user's way with a take of their own: init, track, report, without any
// configuration written by hand. The takes are synthetic, their detector is
// modelled noise.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "core/evaluation/mpjpe.h"
#include "core/io/calibration.h"
#include "core/io/calibration_writer.h"
#include "core/io/tracks.h"
#include "solvers/session/options.h"
#include "tests/support/program.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using testing::ContentOf;
using ::testing::HasSubstr;
using testing::ProgramOutcome;
using testing::ProjectFile;
using testing::RunProgram;
using testing::TemporaryFolder;

struct OwnTake {
  std::string format;
  std::string skeleton;
  double frame_rate_hz;
  double focal_px;
  double radius_m;    // of the cameras' ring
  double unit_per_m;  // of the calibration's lengths
  std::string unit;   // that init must find
  int people;
};

// In a format that states no unit.
void WriteCamerasIn(const OwnTake& take, const std::string& folder) {
  CameraRig cameras;
  for (const Camera& camera : ReadCameras(folder + "/cameras.json")) {
    CameraParameters parameters = camera.parameters();
    parameters.t *= take.unit_per_m;
    cameras.emplace_back(parameters);
  }
  Losses losses;
  WriteCalibration(folder + "/calibration.json", "krt", cameras, &losses);
}

std::string SceneKeys(const OwnTake& take) {
  const int width = static_cast<int>(1.6 * take.focal_px);
  const auto text = [](double value) { return std::to_string(value); };
  return "scene.skeleton=" + take.skeleton +
         ";scene.frame_rate=" + text(take.frame_rate_hz) +
         ";scene.duration=2.5;scene.people=" + std::to_string(take.people) +
         ";scene.motion.visitors=0;scene.motion.area_radius=1.5"
         ";scene.cameras.count=4"
         ";scene.cameras.focal=" +
         text(take.focal_px) + ";scene.cameras.radius=" + text(take.radius_m) +
         ";scene.cameras.image_width=" + std::to_string(width) +
         ";scene.cameras.image_height=" + std::to_string(width * 9 / 16);
}

// Noise that is the same share of a person's size in every image: 4 px at
// 800 px and 6.5 m.
std::string SceneToml(const OwnTake& take) {
  return "[scene]\nseed = 8\n[noise]\nseed = 7\nsigma = " +
         std::to_string(4.0 * take.focal_px / 800.0) +
         "\nreference_depth = 6.5\ncorrelation_time = 0.1\nwhite_share = 0.5\n"
         "missing_rate = 0.03\nconfidence = 0.8\n";
}

class OwnTakes : public ::testing::TestWithParam<OwnTake> {};

ProgramOutcome Expect0(const std::string& command,
                       const std::string& arguments) {
  ProgramOutcome outcome = RunProgram(command, arguments);
  EXPECT_EQ(outcome.exit_code, 0) << command << ": " << outcome.errors;
  return outcome;
}

double ErrorOf(const std::string& tracks, const std::string& truth) {
  return EvaluateMpjpe(ReadTracks(truth), ReadTracks(tracks)).raw_m;
}

TEST_P(OwnTakes, NeedNoConfigurationByHand) {
  const OwnTake& take = GetParam();
  const TemporaryFolder folder;
  const std::string in = folder.path().string();
  const std::string scene = folder.Write("scene.toml", SceneToml(take));
  Expect0("synthesize", "--config='" + scene + "' --set='" + SceneKeys(take) +
                            "' --format=" + take.format + " --out='" + in +
                            "'");
  WriteCamerasIn(take, in);
  const std::string what = "--cameras='" + in + "/calibration.json' " +
                           "--detections='" + in + "/detections_" +
                           take.format + "' ";

  const ProgramOutcome init = Expect0(
      "init", what + "--frame_rate=" + std::to_string(take.frame_rate_hz) +
                  " --out='" + in + "/new/my.toml'");
  EXPECT_THAT(init.output, HasSubstr("skeleton    " + take.skeleton + ","));
  EXPECT_THAT(init.output, HasSubstr("unit        " + take.unit + ":"));
  EXPECT_THAT(init.output, ::testing::Not(HasSubstr("warning")));

  const ProgramOutcome track =
      Expect0("track", what + "--config='" + in + "/new/my.toml' --out='" + in +
                           "/take.jsonl'");
  EXPECT_THAT(track.output, ::testing::Not(HasSubstr("warning")));
  const auto summary =
      nlohmann::json::parse(ContentOf(folder.path() / "take.summary.json"));
  EXPECT_EQ(summary.at("people").size(), static_cast<size_t>(take.people));
  EXPECT_TRUE(summary.at("warnings").empty());

  // By hand: pixels by the rule of configs/paper/pose2sim.toml, with the focal
  // length over the distance; 310 px/m are Shelf's.
  const double scale = take.focal_px / take.radius_m / 310.0;
  const std::string by_hand =
      "gates.units=pixels;association.alpha_2d=" + std::to_string(70 * scale) +
      ";reconstruction.alpha_epi=" + std::to_string(60 * scale) +
      ";initialisation.alpha_group=" + std::to_string(60 * scale) +
      ";initialisation.alpha_filter=" + std::to_string(60 * scale);
  Expect0("track", what + "--config='" + in + "/new/my.toml' --set='" +
                       by_hand + "' --out='" + in + "/by_hand.jsonl'");
  const double error_m = ErrorOf(in + "/take.jsonl", in + "/truth.jsonl");
  EXPECT_LT(error_m,
            1.05 * ErrorOf(in + "/by_hand.jsonl", in + "/truth.jsonl"));
  // 4 px of 800 are 32 mm across at 6.5 m, seen by several cameras.
  EXPECT_LT(error_m, 0.032 * take.radius_m / 6.5);

  Expect0("report", "--tracks='" + in + "/take.jsonl' " + what + "--config='" +
                        in + "/new/my.toml' --out='" + in + "/page/take.html'");
  EXPECT_THAT(ContentOf(folder.path() / "page/take.html"),
              HasSubstr("kinegraph_summary"));
}

INSTANTIATE_TEST_SUITE_P(
    FiveSteps, OwnTakes,
    ::testing::Values(
        OwnTake{"openpose", "body25", 25.0, 800.0, 6.5, 1.0,
                "the calibration's own", 2},
        OwnTake{"openpose", "body25b", 60.0, 1500.0, 7.0, 1000.0, "mm", 2},
        OwnTake{"mmpose", "halpe26", 120.0, 3000.0, 8.0, 1000.0, "mm", 2},
        OwnTake{"coco", "coco17", 60.0, 500.0, 4.5, 1.0,
                "the calibration's own", 2},
        OwnTake{"mediapipe", "mediapipe33", 25.0, 1000.0, 5.0, 100.0, "cm", 1}),
    [](const ::testing::TestParamInfo<OwnTake>& test) {
      return test.param.skeleton;
    });

TEST(OwnTake, TellsWhatIsMissingOrWrong) {
  const TemporaryFolder folder;
  const std::string in = folder.path().string();
  const OwnTake take = {"openpose", "body25", 25.0, 800.0, 6.5, 1.0, "", 1};
  const std::string scene = folder.Write("scene.toml", SceneToml(take));
  Expect0("synthesize", "--config='" + scene + "' --set='" + SceneKeys(take) +
                            "' --format=openpose --out='" + in + "'");
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

TEST(OwnTake, InitKeepsWhatItIsTold) {
  const TemporaryFolder folder;
  const std::string in = folder.path().string();
  const OwnTake take = {"coco", "coco17", 25.0, 800.0, 6.5, 1.0, "", 1};
  const std::string scene = folder.Write("scene.toml", SceneToml(take));
  Expect0("synthesize", "--config='" + scene + "' --set='" + SceneKeys(take) +
                            "' --out='" + in + "'");
  Expect0("init",
          "--cameras='" + in + "/cameras.json' --detections='" + in +
              "/detections.jsonl' --set='cameras.ignore_distortion=true; "
              "mode=graph;tracking.max_gap_s=0.2;output.observations=true;"
              "cameras.map.cam0=cam0' --out='" +
              in + "/my.toml'");
  const RunOptions options = ReadRunOptions(in + "/my.toml", "", "");
  EXPECT_TRUE(options.cameras.ignore_distortion);
  EXPECT_EQ(options.tracker.life.max_gap_s, 0.2);
  EXPECT_EQ(options.cameras.map.at("cam0"), "cam0");
  EXPECT_EQ(options.estimators.output, OutputKind::kBatch);
  const ProgramOutcome unknown = RunProgram(
      "init", "--cameras='" + in + "/cameras.json' --detections='" + in +
                  "/detections.jsonl' --set=cameras.unti=mm --out='" + in +
                  "/x.toml'");
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_THAT(unknown.errors, HasSubstr("cameras.unit"));
}

TEST(OwnTake, TheExtensionChoosesTheFormat) {
  const TemporaryFolder folder;
  const std::string in = folder.path().string();
  const OwnTake take = {"coco", "coco17", 25.0, 800.0, 6.5, 1.0, "", 1};
  const std::string scene = folder.Write("scene.toml", SceneToml(take));
  Expect0("synthesize", "--config='" + scene + "' --set='" + SceneKeys(take) +
                            "' --out='" + in + "'");
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
}

}  // namespace
}  // namespace kinegraph
