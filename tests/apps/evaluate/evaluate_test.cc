// The program kinegraph-evaluate.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "apps/common/config_folder.h"
#include "core/base/time.h"
#include "core/io/calibration/calibration.h"
#include "core/io/detections/writer.h"
#include "core/io/text/json.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/writer.h"
#include "core/skeleton/skeleton.h"
#include "tests/apps/command.h"
#include "tests/core/evaluation/people.h"
#include "tests/support/rig.h"

namespace kinegraph::testing {
namespace {

using ::testing::HasSubstr;

// Expects success and these texts in the output.
void ExpectPrinted(const std::string& flags,
                   const std::vector<std::string>& texts) {
  const std::string output = Done("evaluate", flags).output;
  for (const std::string& text : texts) {
    EXPECT_THAT(output, HasSubstr(text)) << flags;
  }
}

void ExpectRefused(const std::string& flags, const std::string& message) {
  EXPECT_THAT(Refusal("evaluate", flags), HasSubstr(message)) << flags;
}

// One person of tum14 in frames 300 and 301; `lift` moves one ankle up [m].
std::string TrackFile(double lift) {
  std::ostringstream text;
  text << R"({"kinegraph": 1, "units": {"length": "m", "time": "s"},)"
       << R"( "skeleton": {"name": "tum14", "joints": ["r_ankle", "r_knee",)"
       << R"( "r_hip", "l_hip", "l_knee", "l_ankle", "r_wrist", "r_elbow",)"
       << R"( "r_shoulder", "l_shoulder", "l_elbow", "l_wrist",)"
       << R"( "head_bottom", "head_top"], "bones": [[0, 1]]},)"
       << R"( "mode": "paper", "frame_rate": 25.0, "config": {}})"
       << "\n";
  for (int frame = 300; frame < 302; ++frame) {
    text << R"({"frame": )" << frame << R"(, "time": )" << frame / 25.0
         << R"(, "people": [{"id": 0, "joints": [[0.1, 0, )" << lift
         << R"(], [0.1, 0, 0.5],)"
         << R"( [0.1, 0, 1], [-0.1, 0, 1], [-0.1, 0, 0.5], [-0.1, 0, 0],)"
         << R"( [0.3, 0, 1], [0.3, 0, 1.2], [0.2, 0, 1.5], [-0.2, 0, 1.5],)"
         << R"( [-0.3, 0, 1.2], [-0.3, 0, 1], [0, 0, 1.5], [0, 0, 1.8]],)"
         << R"( "status": [)";
    for (int j = 0; j < 14; ++j) text << (j ? ", " : "") << R"("observed")";
    text << "]}]}\n";
  }
  return text.str();
}

class EvaluateProgramTest : public CommandTest {
 protected:
  // The flags that compare a file with a truth.
  std::string Against(const std::string& tracks, const std::string& truth) {
    return " --tracks='" + tracks + "' --ground_truth='" + truth + "'";
  }

  const std::string truth_ = folder_.Write("truth.jsonl", TrackFile(0.0));
  // The ankle is 0.6 m off: the mean error of the lower leg's ends is 0.3 m, at
  // a length of 0.5 m.
  const std::string found_ = folder_.Write("found.jsonl", TrackFile(0.6));
};

TEST_F(EvaluateProgramTest, PrintsPcpAndWritesItAsJson) {
  const std::string json = Path("result.json");
  ExpectPrinted(
      "--protocol=shelf" + Against(found_, truth_) + " --json='" + json + "'",
      {"90.00 (18/20)", "frames 300:601", "covered, %: 100.00 (2/2)",
       "PA-MPJPE, mm: ", "PCK@150mm, %: 92.86 (26/28)"});
  const Json result = ParseJson(ContentOf(json), json)["result"];
  EXPECT_EQ(result["actors"][0]["parts"]["total"]["count"], 18);
  EXPECT_EQ(result["lost"].size(), 2u);
  EXPECT_EQ(result["lost"][0]["part"], "r_lower_leg");
  EXPECT_NEAR(result["lost"][0]["first_error_m"].get<double>(), 0.6, 1e-12);
  EXPECT_EQ(result["protocol"]["head"], "chu");
  EXPECT_EQ(result["person_frames"].size(), 2u);
}

TEST_F(EvaluateProgramTest, FlagsOverrideTheProtocol) {
  ExpectPrinted(
      "--protocol=shelf --head=mvpose --endpoints=each --matching=one_to_one "
      "--frames=300:301,500:501 --lost" +
          Against(found_, truth_),
      {"head mvpose, endpoints each, matching one_to_one, frames "
       "300:301,500:501",
       "90.00 (9/10)", "error of first end, m"});
}

TEST_F(EvaluateProgramTest, OtherProtocolsPrintTheirScores) {
  const std::string against = Against(found_, truth_);
  ExpectPrinted("--protocol=parity" + Against(truth_, truth_),
                {"100.0000 (28/28)"});
  ExpectPrinted("--protocol=parity" + against,
                {"(26/28)", "600.0000 (r_ankle, person 0, frame"});
  // One of 14 joints is 600 mm off.
  ExpectPrinted("--protocol=mpjpe" + against, {"42.9"});
  ExpectPrinted("--protocol=identity" + against, {"MOTA, %"});
  ExpectPrinted("--protocol=panoptic" + against, {"AP, %"});
}

// Offsets are in the body frame, whose upward axis is found from how the people
// of the ground truth stand, whichever axis of the world points up.
TEST_F(EvaluateProgramTest, OffsetsDoNotDependOnTheUpwardAxis) {
  const auto walk = [](const Eigen::Matrix3d& rotation, double error_m) {
    std::vector<TrackFrame> frames;
    for (int f = 0; f < 40; ++f) {
      Pose3d pose = StandingTum14(0.5, -3.0 + 0.05 * f);
      pose[7].position_m += error_m * Eigen::Vector3d(1.0, 2.0, 3.0);
      for (Joint3d& joint : pose)
        joint.position_m = rotation * joint.position_m;
      frames.push_back(Frame(f, {Person(0, std::move(pose))}));
    }
    return Tracks(std::move(frames));
  };
  const auto elbow_m = [&](const Eigen::Matrix3d& rotation) {
    WriteTracks(Path("true.jsonl"), walk(rotation, 0.0));
    WriteTracks(Path("walk.jsonl"), walk(rotation, 0.01));
    const std::string json = Path("result.json");
    Done("evaluate", "--protocol=mpjpe --json='" + json + "'" +
                         Against(Path("walk.jsonl"), Path("true.jsonl")));
    std::vector<double> offset_m;
    const Json result = ParseJson(ContentOf(json), json);
    for (const Json& joint : result["result"]["joints"]) {
      if (joint["joint"] == "r_elbow") joint["offset_m"].get_to(offset_m);
    }
    return offset_m;
  };
  Eigen::Matrix3d z_to_y;
  z_to_y << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  for (const Eigen::Matrix3d& rotation :
       {Eigen::Matrix3d(Eigen::Matrix3d::Identity()), z_to_y}) {
    const std::vector<double> offset_m = elbow_m(rotation);
    ASSERT_EQ(offset_m.size(), 3u);
    EXPECT_NEAR(offset_m[0], 0.01, 1e-4);
    EXPECT_NEAR(offset_m[1], 0.02, 1e-4);
    EXPECT_NEAR(offset_m[2], 0.03, 1e-4);
  }
}

TEST_F(EvaluateProgramTest, CentroidsAreComparedWithHipCentres) {
  // The middle of the hips is at (0, 0, 1) in both frames.
  const auto centroids = [this](const std::string& name, double height_m) {
    std::ostringstream text;
    text << R"({"kinegraph": 1, "units": {"length": "m", "time": "s"},)"
         << R"( "skeleton": {"name": "c", "joints": ["c"], "bones": []},)"
         << R"( "mode": "paper", "frame_rate": 25.0, "config": {}})"
         << "\n";
    for (int frame = 300; frame < 302; ++frame) {
      text << R"({"frame": )" << frame << R"(, "time": )" << frame / 25.0
           << R"(, "people": [{"id": 5, "joints": [[0, 0, )" << height_m
           << R"(]], "status": ["observed"]}]})"
           << "\n";
    }
    return folder_.Write(name, text.str());
  };
  const std::string near = centroids("near.jsonl", 1.25);
  const std::string far = centroids("far.jsonl", 1.75);
  const ProgramOutcome outcome =
      Done("evaluate", "--protocol=identity" + Against(truth_, near));
  EXPECT_THAT(outcome.output, HasSubstr("matches                       2"));
  EXPECT_THAT(outcome.errors, HasSubstr("compared by their centres: 'c' and "
                                        "the middle of the hips"));
  ExpectPrinted("--protocol=identity" + Against(far, truth_),
                {"matches                       0"});
  ExpectRefused("--protocol=mpjpe" + Against(truth_, near),
                "has no joint in common");
}

TEST_F(EvaluateProgramTest, CamerasAreComparedWithTrueCameras) {
  // Three cameras on a line along x that look along z; one of the found cameras
  // is 0.3 m too high.
  const auto file = [this](const std::string& name, double lift_m,
                           int count = 3) {
    std::ostringstream text;
    text << R"({"kinegraph_cameras": 1, "units": {"length": "m"}, )"
         << R"("cameras": [)";
    for (int i = 0; i < count; ++i) {
      text << (i ? ", " : "") << R"({"name": "cam)" << i
           << R"(", "image_size": [640, 480], "model": "pinhole",)"
           << R"( "K": [[600, 0, 320], [0, 600, 240], [0, 0, 1]],)"
           << R"( "distortion": [], "cam_from_world": {"R": [[1, 0, 0],)"
           << R"( [0, 1, 0], [0, 0, 1]], "t": [)" << -2 * i << ", "
           << (i == 1 ? lift_m : 0.0) << ", 0]}}";
    }
    text << "]}";
    return folder_.Write(name, text.str());
  };
  const std::string truth = file("true_cameras.json", 0.0);
  const std::string found = file("cameras.json", 0.3);
  // Alignment removes the mean of 0.1 m: errors of 0.2 m and twice 0.1 m
  // remain.
  const std::string json = Path("result.json");
  ExpectPrinted("--protocol=cameras --cameras='" + found +
                    "' --ground_truth='" + truth + "' --json='" + json + "'",
                {"mean (TE, s-TE, AE)", "RRA@5 deg, %: 100.00 (3/3)",
                 "CCA@15 %, %: 100.00 (3/3)"});
  const Json result = ParseJson(ContentOf(json), json)["result"];
  EXPECT_EQ(result["cameras"].size(), 3u);
  EXPECT_GT(result["te_m"].get<double>(), 0.1);
  EXPECT_LT(result["te_m"].get<double>(), 0.3);
  EXPECT_EQ(result["missing"].size(), 0u);
  const ProgramOutcome partly =
      Done("evaluate", "--protocol=cameras --cameras='" +
                           file("partly.json", 0.0, 2) + "' --ground_truth='" +
                           truth + "' --json='" + json + "'");
  EXPECT_THAT(partly.errors, HasSubstr("note: cam2 of the ground truth was not "
                                       "estimated and is not scored"));
  EXPECT_EQ(ParseJson(ContentOf(json), json)["result"]["missing"],
            Json::array({"cam2"}));
  ExpectRefused("--protocol=cameras --cameras='" + found + "'",
                "--ground_truth");
  ExpectRefused("--protocol=cameras --cameras='" + found +
                    "' --ground_truth='" + truth + "' --tracks='" + found_ +
                    "'",
                "--tracks does not apply");
}

// Some names are those of another program, some are unknown: the known names
// are used.
TEST_F(EvaluateProgramTest, RecognisesJointsUnderOtherNames) {
  const auto renamed =
      [](const std::vector<std::pair<std::string, std::string>>& names) {
        std::string text = TrackFile(0.6);
        for (const auto& [ours, theirs] : names) {
          text.replace(text.find('"' + ours + '"'), ours.size() + 2,
                       '"' + theirs + '"');
        }
        return text;
      };
  const std::string some = folder_.Write(
      "some.jsonl",
      renamed(
          {{"tum14", "mine"}, {"r_ankle", "RAnkle"}, {"r_knee", "patella"}}));
  // 600 mm in one of 13 joints.
  ExpectPrinted("--protocol=mpjpe" + Against(some, truth_), {"46.2"});
  std::vector<std::pair<std::string, std::string>> all = {{"tum14", "mine"}};
  for (const std::string& joint : Tum14().joints()) {
    all.emplace_back(joint, "p" + std::to_string(all.size()));
  }
  const std::string none = folder_.Write("none.jsonl", renamed(all));
  for (const char* protocol :
       {"mpjpe", "identity", "parity", "shelf", "panoptic"}) {
    ExpectRefused(std::string("--protocol=") + protocol + Against(none, truth_),
                  "none.jsonl: has no joint in common");
  }
}

TEST_F(EvaluateProgramTest, BadUsageGivesOneLineAndExitCodeTwo) {
  const std::string both = Against(found_, truth_);
  for (const auto& [flags, message] : std::map<std::string, std::string>{
           {"", "--protocol is required"},
           {"--protocol=shelf", "--tracks is required"},
           {"--protocol=shelf --tracks='" + truth_ + "'",
            "--ground_truth is required"},
           {"--protocol=mall" + both, "found 'mall', expected shelf"},
           {"--protocol=shelf --head=ear" + both, "--head: found 'ear'"},
           {"--protocol=shelf --endpoints=x" + both, "--endpoints: found 'x'"},
           {"--protocol=shelf --matching=x" + both, "--matching: found 'x'"},
           {"--protocol=shelf --frames=5:3" + both, "--frames: found '5:3'"},
           {"--protocol=shelf --frames=1:3" + both, "no person is annotated"},
           {"--protocol=parity --head=chu" + both, "--head does not apply"},
           {"--protocol=mpjpe --lost" + both, "--lost does not apply"},
           {"--protocol=shelf --cameras=x" + both, "--cameras does not apply"},
           {"--protocol=held_out_camera" + both, "--tracks does not apply"},
           {"--protocol=held_out_camera --cameras=x",
            "--detections is required"},
           {"--protocol=held_out_camera --unit=mm", "--unit does not apply"},
           {"--protocol=shelf --tracks=/nowhere --ground_truth='" + truth_ +
                "'",
            "/nowhere"},
           {"--protocol=shelf --json=/dev/null/x.json" + both, "/dev/null"},
           {"--protocol=markers --align=world --drift" + both,
            "--drift: needs --align=both or --align=clock"},
       }) {
    ExpectRefused(flags, message);
  }
}

// A recording for --protocol=held_out_camera.
class EvaluateHeldOutTest : public EvaluateProgramTest {
 protected:
  EvaluateHeldOutTest() {
    const CameraRig rig = RingOfCameras(4);
    WriteCameras(Path("cameras.json"), rig);
    WriteDetections(Path("detections.jsonl"), SeenBy(rig, 60, [](int f) {
                      return std::vector<Pose3d>{StandingPerson(0.02 * f, 0.0)};
                    }));
  }

  const std::string flags_ = "--protocol=held_out_camera --cameras='" +
                             Path("cameras.json") + "' --detections='" +
                             Path("detections.jsonl") + "' ";
  const std::string config_ =
      "--config='" + ProjectConfig("synthetic/track_paper.toml") + "' ";
};

TEST_F(EvaluateHeldOutTest, RefusesAFoldWithoutPeople) {
  ExpectRefused(flags_ + config_ + "--folds=0:30,500:600",
                "500:600 has no detection of a tracked person");
}

TEST_F(EvaluateHeldOutTest, SetAndModeNeedAConfiguration) {
  for (const std::string flag : {"--set=bogus.key=1", "--mode=paper"}) {
    ExpectRefused(flags_ + "--runs=a,b,c,d --reference=e " + flag,
                  "--set, --mode: need --config");
  }
}

// Four seconds of a person who walks away from the origin at 1.5 m/s.
TrackSequence Walker(double rate_hz) {
  TrackSequence tracks = Tracks({});
  tracks.header.mode = "graph";
  tracks.header.frame_rate_hz = rate_hz;
  for (int k = 0; k < static_cast<int>(4.0 * rate_hz); ++k) {
    const double time_s = k / rate_hz;
    tracks.frames.push_back({k,
                             FromSeconds(time_s),
                             {Person(0, StandingTum14(2.0 + 1.5 * time_s))}});
  }
  return tracks;
}

class EvaluateWalkerTest : public EvaluateProgramTest {
 protected:
  std::string Write(const std::string& name, const TrackSequence& tracks,
                    const std::string& format = "kinegraph") {
    LostFields lost_fields;
    FindTrackFormat(format)->write(Path(name), tracks, {}, &lost_fields);
    return Path(name);
  }
  const std::string tracks_ = Write("tracks.jsonl", Walker(25.0));
};

constexpr const char* kProtocols[] = {"mpjpe", "identity", "parity", "panoptic",
                                      "shelf --frames=0:100"};

TEST_F(EvaluateWalkerTest, EveryProtocolPairsByTimeAndReportsIt) {
  const std::string truth = Write("truth.jsonl", Walker(50.0));
  for (const std::string protocol : kProtocols) {
    const std::string json = Path("result.json");
    const ProgramOutcome outcome =
        Done("evaluate", "--protocol=" + protocol + Against(tracks_, truth) +
                             " --json='" + json + "'");
    // With --frames, the range ends with the last frame of the tracks; the
    // truth has another frame 20 ms later.
    const std::string counts =
        protocol == kProtocols[4] ? "100 of 199 true" : "100 of 200 true";
    EXPECT_THAT(
        outcome.errors,
        HasSubstr("the ground truth has 50 Hz, the tracks 25 Hz: " + counts))
        << protocol;
    EXPECT_THAT(ContentOf(json), HasSubstr(counts + " frames"));
  }
  ExpectPrinted("--protocol=mpjpe" + Against(tracks_, truth),
                {"people found, %: 100.00 (100/100)"});
  ExpectPrinted("--protocol=identity" + Against(tracks_, truth),
                {"misses                        0"});
  ExpectPrinted("--protocol=shelf --frames=0:100" + Against(tracks_, truth),
                {"(1000/1000)"});
}

TEST_F(EvaluateWalkerTest, ErrorNamesRatesThatCannotBePaired) {
  TrackSequence truth = Walker(30.0);
  for (TrackFrame& frame : truth.frames) frame.time += 2'500'000;
  const std::string path = Write("truth.jsonl", truth);
  for (const std::string protocol : kProtocols) {
    const std::string line =
        Refusal("evaluate", "--protocol=" + protocol + Against(tracks_, path));
    EXPECT_THAT(line, HasSubstr("30 Hz"));
    EXPECT_THAT(line, HasSubstr("25 Hz"));
  }
}

// With the recommended flags all people are found.
TEST_F(EvaluateWalkerTest, OtherAxesAreReportedWithTheCommandToCorrectThem) {
  const std::string upright = Path("upright.jsonl");
  struct Case {
    const char* name;
    const char* format;
    const char* axes;     // written
    const char* advised;  // to read with
  };
  for (const Case& one :
       {Case{"motive.c3d", "c3d", "x,z,-y", "--axes=x,z,-y"},
        Case{"cortex.trc", "trc", "x,y,z", "--axes=x,y,z"},
        Case{"down.csv", "csv", "x,-y,-z", "--axes=x,-y,-z"}}) {
    SCOPED_TRACE(one.name);
    Done("convert", std::string("--in='") + tracks_ + "' --axes=" + one.axes +
                        " --out='" + Path(one.name) + "'");
    for (const std::string protocol : kProtocols) {
      const std::string line =
          Refusal("evaluate",
                  "--protocol=" + protocol + Against(tracks_, Path(one.name)));
      EXPECT_THAT(line, HasSubstr("0 of 100 true people are near a track"));
      EXPECT_THAT(line, HasSubstr(one.advised)) << protocol;
    }
    Done("convert", std::string("--in='") + Path(one.name) + "' " +
                        one.advised + " --out='" + upright + "'");
    ExpectPrinted("--protocol=mpjpe" + Against(tracks_, upright),
                  {"people found, %: 100.00 (100/100)"});
  }
}

TEST_F(EvaluateWalkerTest, OtherUnitsAreReportedWithTheFlagToCorrectThem) {
  TrackSequence millimetres = Walker(25.0);
  for (TrackFrame& frame : millimetres.frames) {
    for (Joint3d& joint : frame.people[0].joints) joint.position_m *= 1000.0;
  }
  const std::string open = Write("truth.npz", millimetres, "npz");
  const ProgramOutcome refused =
      RunProgram("evaluate", "--protocol=mpjpe" + Against(tracks_, open));
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.errors,
              HasSubstr("lengths times 0.001: `kinegraph convert --in=" + open +
                        " --unit=mm --to=kinegraph --out=NAME.jsonl`"));
  ExpectPrinted("--protocol=mpjpe --unit=mm" + Against(tracks_, open),
                {"people found, %: 100.00 (100/100)"});
  ExpectRefused(
      "--protocol=mpjpe" + Against(tracks_, Write("mm.jsonl", millimetres)),
      "the unit that one of the two files states is wrong");
}

TEST_F(EvaluateWalkerTest, ReportsThatNoPersonIsFound) {
  TrackSequence elsewhere = Walker(25.0);
  for (TrackFrame& frame : elsewhere.frames) {
    frame.people[0].joints = Moved(frame.people[0].joints, 3.0, 9.0);
  }
  const std::string truth = Write("truth.jsonl", elsewhere);
  for (const std::string protocol : kProtocols) {
    EXPECT_THAT(
        Done("evaluate", "--protocol=" + protocol + Against(tracks_, truth))
            .errors,
        HasSubstr("no track is within 0.5 m of a true person"))
        << protocol;
  }
}

// Views of cameras that cameras.use does not list are neither tracked nor held
// out.
TEST_F(EvaluateProgramTest, HoldsOutOnlyTheCamerasThatAreUsed) {
  const CameraRig rig = RingOfCameras(5);
  const std::string config = folder_.Write(
      "use.toml",
      "mode = \"paper\"\n[cameras]\nuse = [\"cam0\", \"cam1\", \"cam3\", "
      "\"cam4\"]\n[cameras.map]\ncam1 = \"cam1\"\n");
  WriteCameras(Path("cameras.json"), rig);
  WriteDetections(Path("detections.jsonl"), SeenBy(rig, 50, [](int f) {
                    return std::vector<Pose3d>{StandingPerson(0.01 * f, 0.0)};
                  }));
  const std::string json = Path("result.json");
  Done("evaluate", "--protocol=held_out_camera --cameras='" +
                       Path("cameras.json") + "' --detections='" +
                       Path("detections.jsonl") + "' --config='" + config +
                       "' --json='" + json + "'");
  EXPECT_EQ(ParseJson(ContentOf(json), json)["result"]["cap_px"].size(), 4u);
}

TEST(EvaluateProgramOnShelfTest, ScoresHeldOutCamerasOfGivenRuns) {
  KINEGRAPH_DATA_OR_SKIP(shelf, "shelf");
  const std::string reference = shelf + "/reference/";
  std::string runs;
  for (int camera = 0; camera < 5; ++camera) {
    runs += (camera ? "," : "") + reference + "paper_code_shelf_without_cam" +
            std::to_string(camera) + ".json";
  }
  const std::string scoring =
      "--protocol=held_out_camera --cameras=" + shelf +
      "/calibration.json --detections=" + shelf + "/detections/openpose" +
      " --held_out_set=" + reference + "held_out_set.json";
  ExpectPrinted(scoring + " --reference=" + reference +
                    "paper_code_shelf_warm3.json --runs=" + runs,
                {"11.01 [", "45.69 [", "13.77 [", "93.05 (46146/49594)",
                 "93.93 (3421/3642)"});
  ExpectRefused(scoring + " --runs=" + runs, "requires --reference");
  ExpectRefused(scoring + " --runs=" + runs.substr(0, runs.find(',')),
                "expected one for each of the 5");
}

}  // namespace
}  // namespace kinegraph::testing
