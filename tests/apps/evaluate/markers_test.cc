// evaluate --protocol=markers as its users meet it: Theia3D against optical
// markers, on the developers' data.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <string>

#include "core/io/files/text_file.h"
#include "core/io/text/json.h"
#include "core/io/tracks/tracks.h"
#include "core/io/tracks/writer.h"
#include "tests/support/program.h"
#include "tests/support/test_data.h"

namespace kinegraph::testing {
namespace {

using ::testing::HasSubstr;

constexpr char kFolder[] = "markers/qualisys_theia";

class MarkersProgramTest : public ::testing::Test {
 protected:
  ProgramOutcome Run(const std::string& tracks, const std::string& truth,
                     const std::string& flags) {
    json_.clear();
    const std::string path = (folder_.path() / "markers.json").string();
    std::filesystem::remove(path);
    const ProgramOutcome outcome =
        RunProgram("evaluate", "--protocol=markers --tracks='" + tracks +
                                   "' --ground_truth='" + truth + "' --json='" +
                                   path + "' " + flags);
    if (outcome.exit_code == 0) json_ = ParseJson(ReadTextFile(path), path);
    return outcome;
  }

  // One line that says so, and nothing written.
  void ExpectRefused(const ProgramOutcome& outcome, const std::string& cause) {
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_THAT(outcome.errors, HasSubstr(cause));
    EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'), 1)
        << outcome.errors;
    EXPECT_FALSE(std::filesystem::exists(folder_.path() / "markers.json"));
  }

  // The segments' origins of a file, moved in time and space, as our tracks.
  std::string Moved(const std::string& path, double late_s,
                    const Eigen::Isometry3d& motion) {
    TrackSequence tracks = ReadTracks(path);
    for (TrackFrame& frame : tracks.frames) {
      frame.time += FromSeconds(late_s);
      for (PersonPose& person : frame.people) {
        for (Joint3d& joint : person.joints) {
          joint.position_m = motion * joint.position_m;
        }
      }
    }
    const std::string moved = (folder_.path() / "moved.jsonl").string();
    WriteTracks(moved, tracks);
    return moved;
  }

  TemporaryFolder folder_;
  Json json_;
};

TEST_F(MarkersProgramTest, TheiaAgainstMarkersAsAnIndependentScriptHasIt) {
  KINEGRAPH_DATA_OR_SKIP(data, kFolder);
  const ProgramOutcome outcome =
      Run(data + "/dynamic_1_theia.c3d", data + "/dynamic_1_markers.c3d",
          "--align=none --plates");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  const std::pair<const char*, double> known[] = {
      {"l_knee", 14.3},  {"r_knee", 12.5},  {"l_elbow", 23.7},
      {"r_elbow", 21.0}, {"l_wrist", 10.2}, {"r_wrist", 14.9}};
  for (const auto& [joint, median_mm] : known) {
    // Half of the last digit given.
    EXPECT_NEAR(json_["joints"][joint]["median_mm"].get<double>(), median_mm,
                0.05)
        << joint;
  }
  EXPECT_NEAR(json_["pooled"]["mean_of_medians_mm"].get<double>(), 16.1, 0.05);
  EXPECT_EQ(json_["clock_s"].get<double>(), 0.0);
  EXPECT_EQ(json_["rotation_deg"].get<double>(), 0.0);
  // A jump: both feet leave and land. Theia's filter (20 Hz) smears landings
  // over some 20 ms; the markers' own events are good to a sample of 5 ms.
  const Json& plates = json_["plates"];
  EXPECT_EQ(plates["tracks"]["events"].size(), 4u);
  EXPECT_LT(plates["ground_truth"]["mean_size_ms"].get<double>(), 5.0);
  EXPECT_LT(plates["tracks"]["mean_size_ms"].get<double>(), 20.0);
  std::istringstream lines(outcome.output);
  for (std::string line; std::getline(lines, line);) {
    EXPECT_LE(line.size(), 100u) << line;
  }
}

TEST_F(MarkersProgramTest, AShiftAndATurnAreTakenOff) {
  KINEGRAPH_DATA_OR_SKIP(data, kFolder);
  const std::string theia = data + "/dynamic_1_theia.c3d";
  const std::string markers = data + "/dynamic_1_markers.c3d";
  ASSERT_EQ(Run(theia, markers, "").exit_code, 0);
  const Json before = json_;
  // Nobody knows the laboratory's clock to better than a third of a frame.
  EXPECT_NEAR(before["clock_s"].get<double>(), 0.0, 0.002);
  for (const Eigen::Vector3d& axis :
       {Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(1, 2, -1)}) {
    Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
    motion.linear() = Eigen::AngleAxisd(40.0 * M_PI / 180.0, axis.normalized())
                          .toRotationMatrix();
    ASSERT_EQ(Run(Moved(theia, -0.137, motion), markers, "").exit_code, 0);
    EXPECT_NEAR(
        json_["clock_s"].get<double>() - before["clock_s"].get<double>(), 0.137,
        1e-4);
    for (const auto& [joint, scores] : before["joints"].items()) {
      EXPECT_NEAR(json_["joints"][joint]["median_mm"].get<double>(),
                  scores["median_mm"].get<double>(), 0.05)
          << joint;
    }
    // The registration of before, and then the turn back.
    Eigen::Matrix3d was, is;
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) {
        was(row, column) = before["truth_from_tracks"]["R"][row][column];
        is(row, column) = json_["truth_from_tracks"]["R"][row][column];
      }
    }
    EXPECT_TRUE((is * motion.linear()).isApprox(was, 1e-5));
  }
}

TEST_F(MarkersProgramTest, AFolderWithTablesPlotsAndPage) {
  KINEGRAPH_DATA_OR_SKIP(data, kFolder);
  const std::string out = (folder_.path() / "out").string();
  const ProgramOutcome outcome =
      Run(data + "/dynamic_1_theia.c3d", data + "/dynamic_1_markers.c3d",
          "--out='" + out + "'");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  for (const char* name : {"markers.json", "markers.md", "bland_altman.svg",
                           "errors.svg", "page.html"}) {
    EXPECT_TRUE(std::filesystem::exists(out + "/" + name)) << name;
  }
  EXPECT_THAT(ContentOf(out + "/page.html"), HasSubstr("LKneeOut"));
  EXPECT_EQ(ParseJson(ReadTextFile(out + "/markers.json"), "")["joints"],
            json_["joints"]);
}

TEST_F(MarkersProgramTest, OwnRulesSayWhatAJointIs) {
  KINEGRAPH_DATA_OR_SKIP(data, kFolder);
  const std::string rules =
      folder_.Write("joints.toml",
                    "[joints.l_knee]\n"
                    "middle_of = [\"LKneeOut\", \"LKneeIn\"]\n"
                    "[joints.l_ankle]\n"
                    "marker = \"LAnkleOut\"\n"
                    "along = [\"LKneeOut\", \"l_knee\"]\n"
                    "by_mm = 42\n"
                    "[joints.l_hip]\n"
                    "regression = \"bell\"\n"
                    "asis = [\"WaistLFront\", \"WaistRFront\"]\n"
                    "psis = [\"WaistBack\"]\n");
  const std::string theia = data + "/dynamic_1_theia.c3d";
  const std::string markers = data + "/dynamic_1_markers.c3d";
  const ProgramOutcome outcome =
      Run(theia, markers, "--align=none --joints='" + rules + "'");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_EQ(json_["joints"].size(), 3u);
  EXPECT_NEAR(json_["joints"]["l_knee"]["median_mm"].get<double>(), 14.3, 0.05);
  const std::string wrong = folder_.Write(
      "wrong.toml", "[joints.l_knee]\nmiddle_of = [\"LKneeMiddle\"]\n");
  ExpectRefused(Run(theia, markers, "--joints='" + wrong + "'"), "no marker");
  const std::string typo = folder_.Write(
      "typo.toml", "[joints.l_knee]\nmiddel_of = [\"LKneeIn\"]\n");
  ExpectRefused(Run(theia, markers, "--joints='" + typo + "'"), "middel_of");
}

TEST_F(MarkersProgramTest, RefusesWithItsCause) {
  KINEGRAPH_DATA_OR_SKIP(data, kFolder);
  const std::string theia = data + "/dynamic_1_theia.c3d";
  const std::string markers = data + "/dynamic_1_markers.c3d";
  ExpectRefused(
      Run(data + "/static_1_theia.c3d", data + "/static_1_markers.c3d", ""),
      "no motion to align");
  const Eigen::Isometry3d same = Eigen::Isometry3d::Identity();
  ExpectRefused(Run(Moved(theia, 100.0, same), markers, "--align=none"),
                "clocks do not overlap");
  ExpectRefused(Run(theia, markers, "--align=sideways"), "both, clock");
  ExpectRefused(Run(theia, markers, "--person=7"), "no person 7");
  ExpectRefused(Run(markers, theia, "--plates"), "force plates");
  ExpectRefused(Run(theia, markers, "--head=raw"), "--head");
}

}  // namespace
}  // namespace kinegraph::testing
