// A new user's steps with a recording of their own: init, track, report,
// without a hand-written configuration. The recordings are synthetic, with
// modelled detector noise.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "core/evaluation/identity.h"
#include "core/evaluation/mpjpe.h"
#include "core/io/calibration/calibration.h"
#include "core/io/calibration/format.h"
#include "core/io/tracks/tracks.h"
#include "solvers/cameras/camera_change.h"
#include "solvers/session/options.h"
#include "tests/apps/command.h"
#include "tests/support/faulty_scene.h"
#include "tests/support/opensim_trc.h"
#include "tests/support/test_data.h"

namespace kinegraph::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::string Text(double value) { return std::to_string(value); }

struct OwnRecording {
  std::string format;
  std::string skeleton;
  double frame_rate_hz = 25.0;
  double focal_px = 800.0;
  double unit_per_m = 1.0;  // of the calibration's lengths
  int people = 2;
  double duration_s = 2.5;

  // Radius of the cameras' ring, larger for longer focal lengths.
  double radius_m() const { return 4.0 + focal_px / 750.0; }
  // "body25_25hz_800px_m"
  std::string name() const {
    return skeleton + "_" + std::to_string(std::lround(frame_rate_hz)) + "hz_" +
           std::to_string(std::lround(focal_px)) + "px_" +
           (unit_per_m == 1000.0 ? "mm" : "m");
  }
};

// A pairwise covering design over formats, rates, units and focal lengths of
// 500 to 3000 px: every pair of values of two of the four occurs at least once.
// Twenty pairs of detector and focal length; rate and unit cycle so that they
// occur with each of these and with each other.
std::vector<OwnRecording> CoveringRecordings() {
  constexpr double kRatesHz[] = {25.0, 60.0, 120.0};
  constexpr double kUnitsPerM[] = {1.0, 1000.0};
  constexpr double kFocalsPx[] = {500.0, 1000.0, 1700.0, 3000.0};
  // MediaPipe finds one person.
  const struct {
    const char* format;
    const char* skeleton;
    int people;
  } kDetectors[] = {{"openpose", "body25", 2},
                    {"openpose", "body25b", 2},
                    {"mmpose", "halpe26", 2},
                    {"coco", "coco17", 2},
                    {"mediapipe", "mediapipe33", 1}};
  std::vector<OwnRecording> recordings;
  for (size_t d = 0; d < std::size(kDetectors); ++d) {
    for (size_t f = 0; f < std::size(kFocalsPx); ++f) {
      const auto& [format, skeleton, people] = kDetectors[d];
      recordings.push_back({format, skeleton, kRatesHz[(d + f) % 3],
                            kFocalsPx[f], kUnitsPerM[(d + f / 2) % 2], people});
    }
  }
  return recordings;
}

// Writes the recording to the folder: detections in the detector's format, and
// calibration.json in a format that does not state its unit. Noise is the same
// fraction of a person's size in every image: 4 px at a focal length of 800 px
// and a distance of 6.5 m.
void MakeOwnRecording(const OwnRecording& recording,
                      const std::string& folder) {
  const std::string focal = Text(recording.focal_px);
  const int width = static_cast<int>(1.6 * recording.focal_px);
  std::ofstream(folder + "/scene.toml")
      << "[scene]\nseed = 8\n[noise]\nseed = 7\nsigma = "
      << 4.0 * recording.focal_px / 800.0
      << "\nreference_depth = 6.5\ncorrelation_time = 0.1\nwhite_share = 0.5\n"
         "missing_rate = 0.03\nconfidence = 0.8\n";
  Done("synthesize",
       "--config='" + folder + "/scene.toml' --format=" + recording.format +
           " --out='" + folder +
           "' --set='scene.skeleton=" + recording.skeleton +
           ";scene.frame_rate=" + Text(recording.frame_rate_hz) +
           ";scene.duration=" + Text(recording.duration_s) +
           ";scene.people=" + std::to_string(recording.people) +
           ";scene.motion.visitors=0;scene.motion.area_radius=1.5"
           ";scene.cameras.count=4;scene.cameras.focal=" +
           focal + ";scene.cameras.radius=" + Text(recording.radius_m()) +
           ";scene.cameras.image_width=" + std::to_string(width) +
           ";scene.cameras.image_height=" + std::to_string(width * 9 / 16) +
           "'");
  LostFields lost_fields;
  WriteCalibration(
      folder + "/calibration.json", "krt",
      Rescaled(ReadCameras(folder + "/cameras.json"), recording.unit_per_m),
      &lost_fields);
}

// Overrides that a user might write: gates in pixels, the paper's values for
// Shelf scaled by focal length over distance, which is 310 px/m on Shelf.
std::string HandMadeKeys(const OwnRecording& recording) {
  const double scale = recording.focal_px / recording.radius_m() / 310.0;
  return "gates.units=pixels;association.alpha_2d=" + Text(70 * scale) +
         ";reconstruction.alpha_epi=" + Text(60 * scale) +
         ";initialisation.alpha_group=" + Text(60 * scale) +
         ";initialisation.alpha_filter=" + Text(60 * scale);
}

class OwnRecordings : public ::testing::TestWithParam<OwnRecording> {};

// Init, track, report; then track again with hand-made gates.
TEST_P(OwnRecordings, NeedNoHandWrittenConfiguration) {
  const OwnRecording& recording = GetParam();
  const TemporaryFolder temporary;
  const std::string folder = temporary.path().string();
  MakeOwnRecording(recording, folder);
  const std::string inputs = "--cameras='" + folder +
                             "/calibration.json' --detections='" + folder +
                             "/detections_" + recording.format + "' ";
  const std::string config = "--config='" + folder + "/new/my.toml' ";
  const std::string take = folder + "/take.jsonl";
  const ProgramOutcome init =
      Done("init", inputs + "--frame_rate=" + Text(recording.frame_rate_hz) +
                       " --out='" + folder + "/new/my.toml'");
  const ProgramOutcome track =
      Done("track", inputs + config + "--out='" + take + "'");
  Done("report", "--tracks='" + take + "' " + inputs + config + "--out='" +
                     folder + "/page/take.html'");
  Done("track", inputs + config + "--set='" + HandMadeKeys(recording) +
                    "' --out='" + folder + "/by_hand.jsonl'");
  if (HasFailure()) return;
  EXPECT_THAT(init.output,
              HasSubstr("skeleton    " + recording.skeleton + ","));
  EXPECT_THAT(init.output,
              HasSubstr(recording.unit_per_m == 1000.0
                            ? "unit        mm:"
                            : "unit        the calibration's own:"));
  EXPECT_THAT(init.output, ::testing::Not(HasSubstr("warning")));
  EXPECT_THAT(track.output, ::testing::Not(HasSubstr("warning")));
  const auto summary =
      nlohmann::json::parse(ContentOf(folder + "/take.summary.json"));
  EXPECT_EQ(summary.at("people").size(), static_cast<size_t>(recording.people));
  EXPECT_TRUE(summary.at("warnings").empty());
  const TrackSequence truth = ReadTracks(folder + "/truth.jsonl");
  const TrackSequence tracks = ReadTracks(take);
  const IdentityResult identity = EvaluateIdentity(truth, tracks);
  EXPECT_EQ(identity.switches, 0);
  EXPECT_EQ(identity.identities, recording.people);
  const double error_m = EvaluateMpjpe(truth, tracks).raw_m;  // mean of joints
  EXPECT_LE(
      error_m,
      1.05 * EvaluateMpjpe(truth, ReadTracks(folder + "/by_hand.jsonl")).raw_m);
  // The noise is 32 mm at any distance: 4 px at a focal length of 800 px and
  // 6.5 m. Several cameras reduce it; the bound is lower for near cameras.
  EXPECT_LT(error_m, 0.032 * recording.radius_m() / 6.5);
  EXPECT_THAT(ContentOf(folder + "/page/take.html"),
              HasSubstr("kinegraph_summary"));
}

INSTANTIATE_TEST_SUITE_P(Covering, OwnRecordings,
                         ::testing::ValuesIn(CoveringRecordings()),
                         [](const auto& test) { return test.param.name(); });

class SmallRecording : public ::testing::Test {
 protected:
  // Makes a recording in the folder `in`.
  void Make(const std::string& format, const std::string& skeleton,
            int people = 1, double duration_s = 2.5) {
    MakeOwnRecording({format, skeleton, 25.0, 800.0, 1.0, people, duration_s},
                     in);
  }
  // Flags for the inputs and the output.
  std::string Flags(const std::string& out,
                    const std::string& cameras = "cameras.json",
                    const std::string& detections = "detections.jsonl") const {
    return "--cameras='" + in + "/" + cameras + "' --detections='" + in + "/" +
           detections + "' --out='" + in + "/" + out + "' ";
  }

  const TemporaryFolder folder;
  const std::string in = folder.path().string();
};

TEST_F(SmallRecording, ErrorsNameWhatIsMissingOrWrong) {
  Make("openpose", "body25");
  const auto flags = [&](const std::string& out) {
    return Flags(out, "cameras.json", "detections_openpose");
  };
  EXPECT_THAT(Refusal("init", flags("my.toml")), HasSubstr("never guessed"));
  EXPECT_EQ(ContentOf(folder.path() / "my.toml"), "");
  EXPECT_THAT(Refusal("track", flags("take.jsonl")),
              HasSubstr("input.frame_rate"));
  EXPECT_THAT(Refusal("track", flags("take.xyz") + "--set=input.frame_rate=25"),
              HasSubstr("must end in .jsonl, .csv, .npz, .trc"));
}

TEST_F(SmallRecording, OfferedCalibrationIsQuotedAndKeepsKeys) {
  Make("coco", "coco17");
  std::filesystem::rename(in + "/detections.jsonl",
                          in + "/my detections.jsonl");
  const std::string given =
      "--set='input.frame_rate=25;detections.skeleton=coco17'";
  const std::string offer =
      Refusal("init", "--detections='" + in + "/my detections.jsonl' " + given +
                          " --out='" + in + "/my.toml'");
  EXPECT_THAT(offer, AllOf(HasSubstr("kinegraph calibrate --detections='" + in +
                                     "/my detections.jsonl' --image_size="),
                           HasSubstr(given)));
}

// An unusable --out is refused before the report is printed (Refusal).
TEST_F(SmallRecording, InitChecksItsOutputFirst) {
  Make("coco", "coco17");
  std::filesystem::create_directory(in + "/folder.toml");
  EXPECT_THAT(Refusal("init", Flags("folder.toml")), HasSubstr("folder.toml"));
  std::ofstream(in + "/file") << "1";
  EXPECT_THAT(Refusal("init", Flags("file/my.toml")), HasSubstr("file"));
}

TEST_F(SmallRecording, InitKeepsGivenKeys) {
  Make("coco", "coco17");
  Done("init", Flags("my.toml") +
                   "--set='cameras.ignore_distortion=true; "
                   "mode=graph;tracking.max_gap_s=0.2;output.observations=true;"
                   "cameras.map.cam0=cam0;cameras.use=[cam0,cam1,cam2,cam3];"
                   "input.frame_rate=25'");
  const RunOptions options = ReadRunOptions(in + "/my.toml", "", "");
  EXPECT_TRUE(options.cameras.ignore_distortion);
  EXPECT_EQ(options.tracker.life.max_gap_s, 0.2);
  EXPECT_EQ(options.cameras.map.at("cam0"), "cam0");
  EXPECT_EQ(options.cameras.use.size(), 4u);
  EXPECT_EQ(options.input.frame_rate_hz, 25.0);
  EXPECT_EQ(options.estimators.output, OutputKind::kBatch);
  EXPECT_THAT(Refusal("init", Flags("x.toml") + "--set=cameras.unti=mm"),
              HasSubstr("cameras.unit"));
}

TEST_F(SmallRecording, InitLeavesOutCamerasThatSetUses) {
  Make("coco", "coco17");
  Done("init", Flags("my.toml") +
                   "--set='cameras.use=[cam0,cam1,cam2];input.frame_rate=25' "
                   "--without_cameras=cam2");
  EXPECT_THAT(ReadRunOptions(in + "/my.toml", "", "").cameras.use,
              ::testing::ElementsAre("cam0", "cam1"));
}

TEST_F(SmallRecording, InitQuotesNamesOfViews) {
  Make("coco", "coco17");
  for (const std::string name : {"cam right", "cam.left"}) {
    std::string text = ContentOf(in + "/detections.jsonl");
    for (size_t at = 0; (at = text.find("\"cam1\"")) != std::string::npos;) {
      text.replace(at, 6, "\"" + name + "\"");
    }
    folder.Write("renamed.jsonl", text);
    Done("init", Flags("my.toml", "cameras.json", "renamed.jsonl") +
                     "--set='cameras.map." + name +
                     "=cam1;input.view_frame_rate." + name + "=25'");
    const RunOptions options = ReadRunOptions(in + "/my.toml", "", "");
    EXPECT_EQ(options.input.view_frame_rate.at(name), "25");
  }
}

TEST_F(SmallRecording, InitRefusesWhatTrackCouldNotRead) {
  Make("openpose", "body25");
  const std::string views = in + "/detections_openpose";
  const std::string flags =
      "--frame_rate=25 " + Flags("my.toml", "cameras.json", "latin_1");
  std::set<std::filesystem::path> old;
  for (const auto& view : std::filesystem::directory_iterator(views)) {
    old.insert(view.path());
  }
  ASSERT_EQ(old.size(), 4u);
  std::filesystem::create_directory(in + "/latin_1");
  std::string name = "a\xe9";  // paired by order
  for (const auto& view : old) {
    std::filesystem::rename(view, in + "/latin_1/" + name);
    ++name[0];
  }
  EXPECT_THAT(Refusal("init", flags), HasSubstr("is not UTF-8"));
  EXPECT_FALSE(std::filesystem::exists(in + "/my.toml"));
  EXPECT_THAT(Refusal("init", "--cameras=a --detections=b --out=-"),
              HasSubstr("--out: found '-'"));
}

// The written configuration leaves out the view without a camera.
TEST_F(SmallRecording, InitLeavesOutAViewWithoutACamera) {
  Make("coco", "coco17");
  CameraRig cameras = ReadCameras(in + "/cameras.json");
  ASSERT_EQ(cameras.back().name(), "cam3");
  cameras.pop_back();
  WriteCameras(in + "/three.json", cameras);
  const std::string three = Flags("my.toml", "three.json");
  EXPECT_THAT(Refusal("init", three), HasSubstr("view 'cam3' has no camera"));
  Done("init", three + "--without_cameras=cam3");
  EXPECT_THAT(ReadRunOptions(in + "/my.toml", "", "").cameras.use,
              ::testing::ElementsAre("cam0", "cam1", "cam2"));
  Done("track",
       Flags("take.jsonl", "three.json") + "--config='" + in + "/my.toml'");
}

TEST_F(SmallRecording, InitMapsOnlyUsedCameras) {
  Make("coco", "coco17");
  Done("init",
       Flags("my.toml") + "--set=cameras.map.cam3=cam3 --without_cameras=cam3");
  EXPECT_TRUE(ReadRunOptions(in + "/my.toml", "", "").cameras.map.empty());
  Done("track", Flags("take.jsonl") + "--config='" + in + "/my.toml'");
}

// `detections` with the images of view "cam1" `frames_late` frames late.
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

// The configuration from `init` refines rotated cameras, and the clock of a
// camera whose images are late; for a good recording it refines nothing.
TEST_F(SmallRecording, InitEnablesRefinementWhereNeeded) {
  Make("coco", "coco17", 3, 6.0);
  CameraRig turned;
  for (const Camera& camera : ReadCameras(in + "/cameras.json")) {
    turned.push_back(Turned(camera, 0.7, 21 + turned.size()));
  }
  LostFields lost_fields;
  WriteCalibration(in + "/turned.json", "krt", turned, &lost_fields);
  std::ofstream(in + "/late.jsonl")
      << WithLateView(ContentOf(folder.path() / "detections.jsonl"), 4);
  const auto written = [&](const std::string& cameras,
                           const std::string& detections) {
    Done("init", Flags("my.toml", cameras, detections));
    return ReadRunOptions(in + "/my.toml", "", "").refine;
  };
  const RefineOptions sound = written("cameras.json", "detections.jsonl");
  EXPECT_EQ(sound.refine, RefineKind::kOff);
  EXPECT_FALSE(sound.refine_clock);
  EXPECT_EQ(written("turned.json", "detections.jsonl").refine,
            RefineKind::kPose);
  EXPECT_TRUE(written("cameras.json", "late.jsonl").refine_clock);

  // Clocks recorded in a calibration are applied first.
  const std::string config = "--config='" + in + "/my.toml' ";
  Done("track", Flags("clocks.jsonl", "cameras.json", "late.jsonl") + config);
  EXPECT_FALSE(written("clocks.cameras.json", "late.jsonl").refine_clock);

  // The page shows the refined cameras, although --cameras names the
  // calibration.
  written("turned.json", "detections.jsonl");
  Done("track", Flags("take.jsonl", "turned.json") + config);
  EXPECT_THAT(Done("report", Flags("take.html", "turned.json") + config +
                                 "--tracks='" + in + "/take.jsonl'")
                  .output,
              HasSubstr("changed by `track`: " + in + "/take.cameras.json"));
}

TEST_F(SmallRecording, TheExtensionChoosesTheFormat) {
  Make("coco", "coco17");
  size_t frames = 0;
  for (const std::string name : {"take.jsonl", "take.csv", "take.npz"}) {
    Done("track", Flags("sub/" + name));
    const TrackSequence tracks = ReadTracks(in + "/sub/" + name);
    if (frames == 0) frames = tracks.frames.size();
    EXPECT_GT(tracks.frames.size(), 50u) << name;
    EXPECT_LE(tracks.frames.size(), frames) << name;
  }
  Done("track", Flags("sub/people.trc"));
  EXPECT_GT(ReadTracks(in + "/sub/people").frames.size(), 50u);
  EXPECT_TRUE(OpenSimReads(in + "/sub/people"));
  EXPECT_THAT(ContentOf(folder.path() / "sub/people/person_0.trc"),
              HasSubstr("l_hip"));
  Done("track", Flags("osim.trc") + "--markers=opensim");
  EXPECT_TRUE(OpenSimReads(in + "/osim"));
  EXPECT_THAT(ContentOf(folder.path() / "osim/person_0.trc"),
              HasSubstr("LHip"));
  EXPECT_THAT(Refusal("track", Flags("x.jsonl") + "--markers=opensim"),
              HasSubstr("--markers"));
  // Observations are the camera mask of C3D.
  Done("track", Flags("empty.c3d"));
  Done("track", Flags("mask.c3d") + "--set=output.observations=true");
  EXPECT_NE(ContentOf(in + "/empty.c3d"), ContentOf(in + "/mask.c3d"));
}

TEST(OwnRecording, AnUnknownConfigurationListsTheKnownOnes) {
  EXPECT_THAT(
      Refusal("track",
              "--cameras=a --detections=b --config=ofline.toml --out=c.jsonl"),
      AllOf(HasSubstr("ofline.toml: is not there"),
            HasSubstr("default.toml, offline.toml, graph/")));
}

}  // namespace
}  // namespace kinegraph::testing
