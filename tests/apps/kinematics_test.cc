// The program kinegraph-kinematics: tracks to CSV.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "core/base/text.h"
#include "core/io/files/atomic_file.h"
#include "core/io/text/json.h"
#include "core/io/tracks/tracks.h"
#include "core/io/tracks/writer.h"
#include "tests/apps/command.h"
#include "tests/support/standing_person.h"

namespace kinegraph::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

using Row = std::map<std::string, std::string>;

std::vector<Row> ReadCsv(const fs::path& path) {
  std::istringstream stream(ContentOf(path));
  std::string line;
  std::getline(stream, line);
  const std::vector<std::string> header = Split(line, ',');
  std::vector<Row> rows;
  while (std::getline(stream, line)) {
    const std::vector<std::string> cells = Split(line, ',');
    EXPECT_EQ(cells.size(), header.size()) << line;
    Row row;
    for (size_t i = 0; i < std::min(cells.size(), header.size()); ++i) {
      row[header[i]] = cells[i];
    }
    rows.push_back(row);
  }
  return rows;
}

class Kinematics : public CommandTest {
 protected:
  // Three frames of one person, called Anna, whose left knee bends by 0, 45, 90
  // degrees; the right elbow is missing in the second.
  std::string WriteBend() const {
    TrackSequence tracks;
    tracks.header.skeleton = Body25();
    tracks.header.mode = "graph";
    tracks.header.frame_rate_hz = 25.0;
    for (int k = 0; k < 3; ++k) {
      PosedPerson person;
      person.Turn({"l_knee", "l_ankle"}, 45.0 * k, Eigen::Vector3d::UnitY());
      if (k == 1) person.Remove("r_elbow");
      TrackFrame& frame = tracks.frames.emplace_back();
      frame.frame = 10 + k;
      frame.time = TimeNs{40000000} * frame.frame;
      frame.people.push_back(person.pose());
      frame.people.back().id = TrackId(7);
    }
    TrackWriteOptions options;
    options.names = {{TrackId(7), "Anna, first"}};
    WriteTracks(Path("bend.jsonl"), tracks, options);
    return Path("bend.jsonl");
  }

  // The same in a format without times.
  std::string WriteBendWithoutTimes() const {
    Json poses = Json::array();
    for (const TrackFrame& frame : ReadTracks(WriteBend()).frames) {
      Json joints = Json::array();
      for (const Joint3d& joint : frame.people.front().joints) {
        const Eigen::Vector3d& at = joint.position_m;
        joints.push_back(joint.present() ? Json{at.x(), at.y(), at.z()}
                                         : Json(nullptr));
      }
      poses.push_back({{"frame", frame.frame}, {"id", 7}, {"joints", joints}});
    }
    WriteTextFile(Path("p.json"), DumpJson({{"poses", poses}}));
    return Path("p.json");
  }

  ProgramOutcome Run(const std::string& flags) const {
    return Done("kinematics", flags + " --out=" + Path("angles.csv"));
  }
};

TEST_F(Kinematics, WritesOneRowPerPersonAndFrame) {
  const std::string out = Path("new folder/angles.csv");
  const ProgramOutcome outcome =
      Done("kinematics", "--tracks=" + WriteBend() + " '--out=" + out + "'");
  EXPECT_THAT(outcome.errors, HasSubstr("no covariances"));
  EXPECT_THAT(outcome.output, HasSubstr("l_knee_flexion, deg"));
  EXPECT_THAT(outcome.output, HasSubstr("up is (0, 0, 1)"));
  const std::string text = ContentOf(out);
  EXPECT_EQ(text.rfind("frame,time_s,id,name,l_hip_flexion_deg,", 0), 0u);
  EXPECT_THAT(text, HasSubstr("\n11,0.44,7,\"Anna, first\","));
}

TEST_F(Kinematics, MissingValuesAreEmptyCells) {
  Run("--frame_rate=25 --tracks=" + WriteBendWithoutTimes());
  const std::vector<Row> rows = ReadCsv(Path("angles.csv"));
  ASSERT_EQ(rows.size(), 3u);
  for (size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(std::stod(rows[k].at("l_knee_flexion_deg")),
                45.0 * static_cast<double>(k), 1e-9);
  }
  EXPECT_EQ(rows[1].at("time_s"), "0.44");
  EXPECT_EQ(rows[1].at("r_elbow_flexion_deg"), "");
  EXPECT_EQ(rows[1].at("com_x_m"), "");
  EXPECT_EQ(rows[0].at("r_elbow_speed_m_s"), "") << "no frame before";
  EXPECT_EQ(rows[1].at("pelvis_speed_m_s"), "0");
  EXPECT_EQ(rows[0].count("l_knee_flexion_low_deg"), 0u);
}

TEST_F(Kinematics, NoTimesMeanNoSpeeds) {
  EXPECT_THAT(Run("--tracks=" + WriteBendWithoutTimes()).errors,
              HasSubstr("--frame_rate=HZ"));
  const std::vector<Row> rows = ReadCsv(Path("angles.csv"));
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[0].at("time_s"), "");
  EXPECT_EQ(rows[0].count("pelvis_speed_m_s"), 0u);
}

// Pose2Sim's files have some of a skeleton's joints under other names.
TEST_F(Kinematics, RecognisesJointNamesOfOtherPrograms) {
  TrackSequence tracks;
  tracks.header.skeleton = Skeleton("custom", {"RHip", "RKnee", "RAnkle"}, {});
  tracks.header.mode = "graph";
  PosedPerson person;
  person.Turn({"r_knee", "r_ankle"}, 60.0, Eigen::Vector3d::UnitY());
  PersonPose& pose = tracks.frames.emplace_back().people.emplace_back();
  pose.id = TrackId(1);
  for (const char* joint : {"r_hip", "r_knee", "r_ankle"}) {
    pose.joints.push_back({person.At(joint), JointStatus::kObserved});
  }
  WriteTracks(Path("leg.jsonl"), tracks);
  Run("--tracks=" + Path("leg.jsonl"));
  const std::vector<Row> rows = ReadCsv(Path("angles.csv"));
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_NEAR(std::stod(rows[0].at("r_knee_flexion_deg")), 60.0, 1e-9);
}

TEST_F(Kinematics, BadInputGivesOneLineAndExitCodeTwo) {
  const std::string in = "--tracks=" + WriteBend();
  const std::string out = " --out=" + Path("angles.csv");
  const std::string hand =
      folder_.Write("hand.csv",
                    "frame,time_s,id,joint,x_m,y_m,z_m,status\n"
                    "0,0,1,tip,1,2,3,observed\n0,0,1,root,1,2,3,observed\n");
  const std::string nobody =
      folder_.Write("nobody.json", "{\"unit\": \"m\", \"poses\": []}");
  const std::vector<std::pair<std::string, std::string>> cases = {
      {out, "--tracks"},
      {in, "--out"},
      {in + " --out=" + Path("angles.txt"), "NAME.csv"},
      {in + out + " --up=w", "--up: found 'w'"},
      {in + out + " --frame_rate=-1", "--frame_rate"},
      {in + out + " --skeleton=octopus", "--skeleton"},
      {"--tracks=nowhere.jsonl" + out, "nowhere.jsonl"},
      {"--tracks=" + hand + out, "none of the joints"},
      {"--tracks=" + nobody + " --skeleton=coco17" + out, "has no people"}};
  for (const auto& [arguments, expected] : cases) {
    EXPECT_THAT(Refusal("kinematics", arguments), HasSubstr(expected));
    EXPECT_FALSE(fs::exists(Path("angles.csv"))) << arguments;
  }
}

}  // namespace
}  // namespace kinegraph::testing
