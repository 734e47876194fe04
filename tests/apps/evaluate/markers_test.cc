// evaluate --protocol=markers: Theia3D, and tracks from a modelled detector,
// against optical markers, on the developers' data.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>

#include "core/base/random.h"
#include "core/evaluation/markers/marker_sets.h"
#include "core/io/calibration/calibration.h"
#include "core/io/detections/writer.h"
#include "core/io/files/text_file.h"
#include "core/io/text/json.h"
#include "core/io/tracks/tracks.h"
#include "core/io/tracks/writer.h"
#include "tests/apps/command.h"

namespace kinegraph::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// Defines `data`, the folder of the recordings, and the two files of a jump:
// segments of Theia3D and markers; or skips the test.
#define MARKERS_OR_SKIP()                                  \
  KINEGRAPH_DATA_OR_SKIP(data, "markers/qualisys_theia");  \
  const std::string theia = data + "/dynamic_1_theia.c3d"; \
  const std::string markers = data + "/dynamic_1_markers.c3d"

class MarkersProgramTest : public CommandTest {
 protected:
  std::string Flags(const std::string& tracks, const std::string& truth,
                    const std::string& flags) const {
    return "--protocol=markers --tracks='" + tracks + "' --ground_truth='" +
           truth + "' --json='" + result_ + "' " + flags;
  }
  // Returns the output; stores the numbers in `json_`.
  std::string Run(const std::string& tracks, const std::string& truth,
                  const std::string& flags) {
    const std::string output =
        Done("evaluate", Flags(tracks, truth, flags)).output;
    json_ = ParseJson(ReadTextFile(result_), result_);
    return output;
  }

  // Expects a one-line error with this text and no output file.
  void ExpectRefused(const std::string& tracks, const std::string& truth,
                     const std::string& flags, const std::string& cause) {
    std::filesystem::remove(result_);
    EXPECT_THAT(Refusal("evaluate", Flags(tracks, truth, flags)),
                HasSubstr(cause));
    EXPECT_FALSE(std::filesystem::exists(result_));
  }

  // The origins of the segments in a file as tracks, displaced in time and
  // space.
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
    WriteTracks(Path("moved.jsonl"), tracks);
    return Path("moved.jsonl");
  }

  // A number of the result, by its JSON pointer: "/joints/l_knee/median_mm".
  double Number(const std::string& place) const {
    return json_.at(Json::json_pointer(place)).get<double>();
  }

  const std::string result_ = Path("markers.json");
  Json json_;
};

TEST_F(MarkersProgramTest, TheiaComparisonMatchesAnIndependentScript) {
  MARKERS_OR_SKIP();
  const std::string printed = Run(theia, markers, "--align=none --plates");
  const std::pair<const char*, double> known[] = {
      {"l_knee", 14.3},  {"r_knee", 12.5},  {"l_elbow", 23.7},
      {"r_elbow", 21.0}, {"l_wrist", 10.2}, {"r_wrist", 14.9}};
  for (const auto& [joint, median_mm] : known) {
    // Half a unit of the last digit.
    EXPECT_NEAR(Number("/joints/" + std::string(joint) + "/median_mm"),
                median_mm, 0.05)
        << joint;
  }
  EXPECT_NEAR(Number("/pooled/mean_of_medians_mm"), 16.1, 0.05);
  EXPECT_EQ(Number("/clock_s"), 0.0);
  EXPECT_EQ(Number("/rotation_deg"), 0.0);
  // A jump: both feet leave and land. Theia's filter (20 Hz) smears landings
  // over about 20 ms; the markers' own events are accurate to a sample of 5 ms.
  EXPECT_EQ(json_["plates"]["tracks"]["events"].size(), 4u);
  EXPECT_LT(Number("/plates/ground_truth/mean_size_ms"), 5.0);
  EXPECT_LT(Number("/plates/tracks/mean_size_ms"), 20.0);
  std::istringstream lines(printed);
  for (std::string line; std::getline(lines, line);) {
    EXPECT_LE(line.size(), 100u) << line;
  }
}

TEST_F(MarkersProgramTest, TimeShiftAndRotationAreRemoved) {
  MARKERS_OR_SKIP();
  Run(theia, markers, "");
  const Json before = json_;
  // The laboratory's clock is known to a third of a frame at best: 1.7 ms at
  // 200 Hz.
  EXPECT_NEAR(before["clock_s"].get<double>(), 0.0, 0.002);
  for (const Eigen::Vector3d& axis :
       {Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(1, 2, -1)}) {
    Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
    motion.linear() = Eigen::AngleAxisd(40.0 * M_PI / 180.0, axis.normalized())
                          .toRotationMatrix();
    Run(Moved(theia, -0.137, motion), markers, "");
    EXPECT_NEAR(Number("/clock_s") - before["clock_s"].get<double>(), 0.137,
                1e-4);
    for (const auto& [joint, scores] : before["joints"].items()) {
      EXPECT_NEAR(Number("/joints/" + std::string(joint) + "/median_mm"),
                  scores["median_mm"].get<double>(), 0.05)
          << joint;
    }
    // The inverse rotation followed by the previous registration.
    Eigen::Matrix3d was, is;
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) {
        was(row, column) = before["truth_from_tracks"]["R"][row][column];
        is(row, column) = json_["truth_from_tracks"]["R"][row][column];
      }
    }
    EXPECT_TRUE((is * motion.linear()).isApprox(was, 1e-5));
    EXPECT_NEAR(Eigen::AngleAxisd(is.transpose() * was).angle(),
                40.0 * M_PI / 180.0, 0.1 * M_PI / 180.0);
    // The difference from 40 degrees is the rotation between the unchanged
    // recordings: about half a degree, and uncertain by as much, because
    // definitions of joints differ.
    EXPECT_NEAR(Number("/rotation_deg"), 40.0,
                before["rotation_deg"].get<double>() + 0.1);
  }
}

TEST_F(MarkersProgramTest, WritesTablesPlotsAndPage) {
  MARKERS_OR_SKIP();
  const std::string out = Path("out");
  Run(theia, markers, "--out='" + out + "'");
  for (const char* name : {"markers.json", "markers.md", "bland_altman.svg",
                           "errors.svg", "page.html"}) {
    EXPECT_TRUE(std::filesystem::exists(out + "/" + name)) << name;
  }
  EXPECT_THAT(ContentOf(out + "/page.html"), HasSubstr("LKneeOut"));
  EXPECT_EQ(ParseJson(ReadTextFile(out + "/markers.json"), "")["joints"],
            json_["joints"]);
}

// A detector that sees the markers' joints through the laboratory's own
// cameras: with white noise, noise with a correlation time of 0.1 s, and a
// constant offset of each joint in each view, of length `offset_m` in a random
// direction.
struct Detector {
  double white_px = 0.0;
  double correlated_px = 0.0;
  double offset_m = 0.0;
  uint64_t seed = 1;
};

class MarkersFromPixelsTest : public MarkersProgramTest {
 protected:
  // Tracks its detections and scores the result against the markers.
  void Score(const std::string& data, const Detector& detector) {
    const std::string markers = data + "/dynamic_1_markers.c3d";
    const std::string cameras = data + "/qualisys_cal.txt";
    WriteDetections(Path("seen.jsonl"),
                    See(markers, ReadCameras(cameras), detector));
    Done("track", "--cameras='" + cameras + "' --detections='" +
                      Path("seen.jsonl") + "' --config='" +
                      ProjectFile("configs/offline.toml").string() +
                      "' --out='" + Path("tracks.jsonl") + "'");
    printed_ = Run(Path("tracks.jsonl"), markers, "--align=none");
  }

  // Detections in every other frame.
  static DetectionSequence See(const std::string& path, const CameraRig& rig,
                               const Detector& detector) {
    constexpr double kCorrelationS = 0.1;
    const TrackSequence points = ReadTracks(path);
    const MarkerSet* set = RecogniseMarkerSet(points.header.skeleton.joints());
    const TrackSequence joints = JointsOfMarkers(points, *set).tracks;
    const size_t count = joints.header.skeleton.joints().size();
    Random random(detector.seed);
    DetectionSequence seen;
    seen.header.skeleton = joints.header.skeleton;
    seen.header.frame_rate_hz = 0.5 * joints.header.frame_rate_hz;
    const double keeps =
        std::exp(-1.0 / (kCorrelationS * seen.header.frame_rate_hz));
    std::vector<Eigen::Vector2d> correlated, offset_px;
    for (const Camera& camera : rig) {
      seen.header.view_names.push_back(camera.name());
      for (size_t j = 0; j < count; ++j) {
        correlated.push_back(detector.correlated_px *
                             Eigen::Vector2d(random.Normal(), random.Normal()));
        const double angle = random.Uniform(0.0, 2.0 * M_PI);
        // At the distance of the laboratory's centre.
        offset_px.push_back(detector.offset_m * camera.focal_px() /
                            camera.Depth({0.0, 0.0, 1.0}) *
                            Eigen::Vector2d(std::cos(angle), std::sin(angle)));
      }
    }
    for (size_t f = 0; f < joints.frames.size(); f += 2) {
      DetectionFrame frame;
      frame.frame = static_cast<int64_t>(f / 2);
      frame.time = joints.frames[f].time;
      for (size_t v = 0; v < rig.size(); ++v) {
        Detection person;
        person.joints.resize(count);
        for (size_t j = 0; j < count; ++j) {
          Eigen::Vector2d& drift = correlated[v * count + j];
          drift = keeps * drift +
                  detector.correlated_px * std::sqrt(1.0 - keeps * keeps) *
                      Eigen::Vector2d(random.Normal(), random.Normal());
          const Eigen::Vector2d white =
              detector.white_px *
              Eigen::Vector2d(random.Normal(), random.Normal());
          const Joint3d& joint = joints.frames[f].people[0].joints[j];
          if (!joint.present()) continue;
          const auto px = rig[v].Project(joint.position_m);
          if (!px) continue;
          person.joints[j] = {*px + drift + white + offset_px[v * count + j],
                              0.9, true};
        }
        frame.views.push_back({frame.time, {std::move(person)}});
      }
      seen.frames.push_back(std::move(frame));
    }
    return seen;
  }

  std::string printed_;
};

// A jump of 3 s contains about thirty correlation times of the noise (0.1 s):
// the standard error of the coverage is 0.04 for one seed and 0.02 for four.
TEST_F(MarkersFromPixelsTest, CovarianceEllipsoidsHaveNominalCoverage) {
  KINEGRAPH_DATA_OR_SKIP(data, "markers/qualisys_theia");
  constexpr int kSeeds = 4;
  for (const auto& [white_px, correlated_px] :
       {std::pair{2.0, 0.0}, {0.0, 4.0}}) {
    double calibration_error = 0.0, covered_95 = 0.0, angles = 0.0;
    for (int seed = 1; seed <= kSeeds; ++seed) {
      Score(data, {white_px, correlated_px, 0.0, static_cast<uint64_t>(seed)});
      const Json& pooled = json_["pooled"];
      calibration_error += pooled["ece"].get<double>() / kSeeds;
      covered_95 += pooled["coverage_95"].get<double>() / kSeeds;
      for (const Json& angle : json_["angles"]) {
        angles += angle["after_offset_coverage_95"].get<double>() /
                  static_cast<double>(kSeeds * json_["angles"].size());
      }
    }
    const std::string what = std::to_string(white_px) + " px white, " +
                             std::to_string(correlated_px) + " px correlated";
    // The required 0.05, and 0.02 for the standard error of four seeds.
    EXPECT_LE(calibration_error, 0.05 + 0.02) << what;
    EXPECT_NEAR(covered_95, 0.95, 0.03) << what;
    EXPECT_GE(angles, 0.90) << what;
    EXPECT_LE(angles, 0.98) << what;
  }
}

TEST_F(MarkersFromPixelsTest, OutputStatesThatIntervalsExcludeConstantOffsets) {
  KINEGRAPH_DATA_OR_SKIP(data, "markers/qualisys_theia");
  Score(data, {2.0, 0.0, 0.025, 1});
  EXPECT_THAT(printed_, HasSubstr("They do not include"));
  EXPECT_GT(Number("/pooled/median_mm"),
            Number("/pooled/after_offset_median_mm"));
}

TEST_F(MarkersProgramTest, CustomRulesDefineJoints) {
  MARKERS_OR_SKIP();
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
  Run(theia, markers, "--align=none --joints='" + rules + "'");
  EXPECT_EQ(json_["joints"].size(), 3u);
  EXPECT_NEAR(Number("/joints/l_knee/median_mm"), 14.3, 0.05);
  const std::string wrong = folder_.Write(
      "wrong.toml", "[joints.l_knee]\nmiddle_of = [\"LKneeMiddle\"]\n");
  ExpectRefused(theia, markers, "--joints='" + wrong + "'",
                "has all its markers");
  const std::string typo = folder_.Write(
      "typo.toml", "[joints.l_knee]\nmiddel_of = [\"LKneeIn\"]\n");
  ExpectRefused(theia, markers, "--joints='" + typo + "'", "middel_of");
}

// A knee alone: its body has no axes, so bias and limits are missing.
TEST_F(MarkersProgramTest, MissingValuesAreDashes) {
  TrackSequence knee;
  knee.header.skeleton = Skeleton("knee", {"l_knee"}, {});
  knee.header.frame_rate_hz = 50.0;
  Random random(1);
  for (int f = 0; f < 300; ++f) {
    TrackFrame& frame = knee.frames.emplace_back();
    frame.frame = f;
    frame.time = FromSeconds(f / 50.0);
    PersonPose& person = frame.people.emplace_back();
    person.id = TrackId(0);
    person.joints = {
        {Eigen::Vector3d(1.5 * std::cos(f / 50.0) + 0.01 * random.Normal(),
                         1.5 * std::sin(f / 50.0), 0.5),
         JointStatus::kObserved}};
  }
  WriteTracks(Path("tracks.jsonl"), knee);
  Done("convert",
       "--to=trc --in=" + Path("tracks.jsonl") + " --out=" + Path("truth.trc"));
  const std::string printed = Run(Path("tracks.jsonl"), Path("truth.trc"),
                                  "--align=none --out='" + Path("out") + "'");
  for (const std::string& text :
       {printed, ReadTextFile(Path("out/markers.md"))}) {
    EXPECT_THAT(text, HasSubstr("l_knee"));
    EXPECT_THAT(text, Not(HasSubstr("nan")));
  }
  EXPECT_THAT(printed, HasSubstr("- - -"));
}

TEST_F(MarkersProgramTest, ErrorsNameTheCause) {
  MARKERS_OR_SKIP();
  ExpectRefused(data + "/static_1_theia.c3d", data + "/static_1_markers.c3d",
                "", "no motion to align");
  const Eigen::Isometry3d same = Eigen::Isometry3d::Identity();
  ExpectRefused(Moved(theia, 100.0, same), markers, "--align=none",
                "times do not overlap");
  ExpectRefused(theia, markers, "--align=sideways", "both, clock");
  ExpectRefused(theia, markers, "--person=7",
                "--person=7: the tracks have no such person");
  ExpectRefused(markers, theia, "--plates", "force plates");
  ExpectRefused(theia, markers, "--head=raw", "--head");
}

}  // namespace
}  // namespace kinegraph::testing
