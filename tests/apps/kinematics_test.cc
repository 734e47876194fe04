// The program itself: tracks in, a CSV file out.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "core/io/tracks/writer.h"
#include "tests/support/program.h"
#include "tests/support/standing_person.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;
using testing::ContentOf;
using testing::PosedPerson;
using testing::ProgramOutcome;
using testing::RunProgram;
using testing::TemporaryFolder;

using Row = std::map<std::string, std::string>;

std::vector<std::string> Cells(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream stream(line);
  for (std::string cell; std::getline(stream, cell, ',');) {
    cells.push_back(cell);
  }
  if (!line.empty() && line.back() == ',') cells.emplace_back();
  return cells;
}

std::vector<Row> ReadCsv(const fs::path& path) {
  std::istringstream stream(ContentOf(path));
  std::string line;
  std::getline(stream, line);
  const std::vector<std::string> header = Cells(line);
  std::vector<Row> rows;
  while (std::getline(stream, line)) {
    const std::vector<std::string> cells = Cells(line);
    EXPECT_EQ(cells.size(), header.size()) << line;
    Row row;
    for (size_t i = 0; i < std::min(cells.size(), header.size()); ++i) {
      row[header[i]] = cells[i];
    }
    rows.push_back(row);
  }
  return rows;
}

// Three frames of one person, called Anna, whose left knee bends by 0, 45, 90
// degrees; the right elbow is not there in the second.
std::string WriteBend(const TemporaryFolder& folder) {
  TrackSequence tracks;
  tracks.header.skeleton = Body25();
  tracks.header.mode = "graph";
  tracks.header.frame_rate_hz = 25.0;
  for (int k = 0; k < 3; ++k) {
    PosedPerson person;
    person.Turn({"l_knee", "l_ankle"}, 45.0 * k, Eigen::Vector3d::UnitY());
    if (k == 1) person.Remove("r_elbow");
    TrackFrame frame;
    frame.frame = 10 + k;
    frame.time = TimeNs{40000000} * frame.frame;
    frame.people.push_back(person.pose());
    frame.people.back().id = TrackId(7);
    tracks.frames.push_back(frame);
  }
  const std::string path = (folder.path() / "bend.jsonl").string();
  TrackWriteOptions options;
  options.names = {{TrackId(7), "Anna, first"}};
  WriteTracks(path, tracks, options);
  return path;
}

TEST(Kinematics, WritesARowAPersonAndFrame) {
  const TemporaryFolder folder;
  const std::string in = WriteBend(folder);
  const fs::path out = folder.path() / "new folder/angles.csv";
  const ProgramOutcome outcome = RunProgram(
      "kinematics", "--tracks=" + in + " '--out=" + out.string() + "'");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_THAT(outcome.errors, ::testing::HasSubstr("no covariances"));
  EXPECT_THAT(outcome.output, ::testing::HasSubstr("l_knee_flexion, deg"));
  EXPECT_THAT(outcome.output, ::testing::HasSubstr("up is (0, 0, 1)"));
  const std::string text = ContentOf(out);
  EXPECT_EQ(text.rfind("frame,time_s,id,name,l_hip_flexion_deg,", 0), 0u);
  EXPECT_THAT(text, ::testing::HasSubstr("\n11,0.44,7,\"Anna, first\","));
}

TEST(Kinematics, MissingIsAnEmptyCell) {
  const TemporaryFolder folder;
  const std::string in = WriteBend(folder);
  ASSERT_EQ(RunProgram("convert", "--to=poses --in=" + in + " --out=" +
                                      (folder.path() / "p.json").string())
                .exit_code,
            0);
  const fs::path out = folder.path() / "angles.csv";
  const ProgramOutcome outcome = RunProgram(
      "kinematics",
      "--frame_rate=25 --tracks=" + (folder.path() / "p.json").string() +
          " --out=" + out.string());
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  const std::vector<Row> rows = ReadCsv(out);
  ASSERT_EQ(rows.size(), 3u);
  for (size_t k = 0; k < 3; ++k) {
    // The knee's angle to 1e-9 degrees.
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

TEST(Kinematics, WithoutTimesThereAreNoSpeeds) {
  const TemporaryFolder folder;
  const std::string in = WriteBend(folder);
  const std::string poses = (folder.path() / "p.json").string();
  ASSERT_EQ(RunProgram("convert", "--to=poses --in=" + in + " --out=" + poses)
                .exit_code,
            0);
  const fs::path out = folder.path() / "angles.csv";
  const ProgramOutcome outcome =
      RunProgram("kinematics", "--tracks=" + poses + " --out=" + out.string());
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_THAT(outcome.errors, ::testing::HasSubstr("--frame_rate=HZ"));
  const std::vector<Row> rows = ReadCsv(out);
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[0].at("time_s"), "");
  EXPECT_EQ(rows[0].count("pelvis_speed_m_s"), 0u);
}

// Pose2Sim's files have some of a skeleton's joints under names of their own.
TEST(Kinematics, OtherProgramsNamesAreKnown) {
  const TemporaryFolder folder;
  TrackSequence tracks;
  tracks.header.skeleton = Skeleton("custom", {"RHip", "RKnee", "RAnkle"}, {});
  tracks.header.mode = "graph";
  PosedPerson person;
  person.Turn({"r_knee", "r_ankle"}, 60.0, Eigen::Vector3d::UnitY());
  TrackFrame frame;
  frame.people.resize(1);
  frame.people[0].id = TrackId(1);
  for (const char* joint : {"r_hip", "r_knee", "r_ankle"}) {
    frame.people[0].joints.push_back(
        {person.At(joint), JointStatus::kObserved});
  }
  tracks.frames.push_back(frame);
  const std::string in = (folder.path() / "leg.jsonl").string();
  WriteTracks(in, tracks);
  const fs::path out = folder.path() / "angles.csv";
  const ProgramOutcome outcome =
      RunProgram("kinematics", "--tracks=" + in + " --out=" + out.string());
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  const std::vector<Row> rows = ReadCsv(out);
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_NEAR(std::stod(rows[0].at("r_knee_flexion_deg")), 60.0, 1e-9);
}

TEST(Kinematics, BadInputIsOneLineAndExitTwo) {
  const TemporaryFolder folder;
  const std::string in = "--tracks=" + WriteBend(folder);
  const std::string out = " --out=" + (folder.path() / "angles.csv").string();
  const std::string hand =
      folder.Write("hand.csv",
                   "frame,time_s,id,joint,x_m,y_m,z_m,status\n"
                   "0,0,1,tip,1,2,3,observed\n0,0,1,root,1,2,3,observed\n");
  const std::string nobody =
      folder.Write("nobody.json", "{\"unit\": \"m\", \"poses\": []}");
  const std::vector<std::pair<std::string, std::string>> cases = {
      {out, "--tracks"},
      {in, "--out"},
      {in + " --out=" + (folder.path() / "angles.txt").string(), "NAME.csv"},
      {in + out + " --up=w", "--up: found 'w'"},
      {in + out + " --frame_rate=-1", "--frame_rate"},
      {in + out + " --skeleton=octopus", "--skeleton"},
      {"--tracks=nowhere.jsonl" + out, "nowhere.jsonl"},
      {"--tracks=" + hand + out, "none of the joints"},
      {"--tracks=" + nobody + " --skeleton=coco17" + out, "has no people"}};
  for (const auto& [arguments, expected] : cases) {
    const ProgramOutcome outcome = RunProgram("kinematics", arguments);
    EXPECT_EQ(outcome.exit_code, 2) << arguments << outcome.errors;
    EXPECT_THAT(outcome.errors, ::testing::HasSubstr(expected)) << arguments;
    EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'), 1)
        << outcome.errors;
    EXPECT_FALSE(fs::exists(folder.path() / "angles.csv")) << arguments;
  }
}

}  // namespace
}  // namespace kinegraph
