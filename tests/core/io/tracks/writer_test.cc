#include "core/io/tracks/writer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <sstream>
#include <stdexcept>
#include <string>

#include "core/base/random.h"
#include "core/io/files/text_file.h"
#include "core/io/tracks/tracks.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using testing::TemporaryFolder;

// A number of any order of magnitude, with all digits.
double Wild(Random* random) {
  return random->Normal() * std::pow(10.0, random->Uniform(-300.0, 300.0));
}

PersonPose MakePerson(int64_t id, Random* random) {
  PersonPose person;
  person.id = TrackId(id);
  person.score = random->Uniform();
  for (const int view_idx : {2, 0}) {
    person.matches.push_back(
        {view_idx, static_cast<int>(random->Index(9)), {}});
  }
  for (int j = 0; j < 17; ++j) {
    Joint3d joint;
    joint.status = static_cast<JointStatus>(random->Index(3));
    if (joint.present()) {
      joint.position_m = {Wild(random), Wild(random), Wild(random)};
    }
    person.joints.push_back(joint);
    person.inlier_views.push_back(static_cast<int>(random->Index(5)));
    person.covariances.emplace_back();
    if (joint.present() && random->Chance(0.7)) {
      Eigen::Matrix3d c;
      for (int r = 0; r < 3; ++r) {
        for (int k = r; k < 3; ++k) c(r, k) = c(k, r) = Wild(random);
      }
      person.covariances.back() = c;
    }
    for (ViewMatch& match : person.matches) {
      match.weights.emplace_back();
      if (random->Chance(0.6)) match.weights.back() = random->Uniform();
    }
  }
  return person;
}

TrackSequence RandomSequence() {
  Random random(7);
  TrackSequence sequence;
  sequence.header.skeleton = Coco17();
  sequence.header.mode = "graph";
  sequence.header.frame_rate_hz = 29.97;
  sequence.header.view_names = {"cam0", "cam \"1\"", "cam2"};
  sequence.header.config_json = R"({"a":{"b":[1,2.50,1e-3]},"c":"d e"})";
  for (int64_t f = 0; f < 20; ++f) {
    TrackFrame& frame = sequence.frames.emplace_back();
    frame.frame = 3 * f;
    frame.time = 100'000'000'000'001 + f * 33'366'700;
    for (int64_t id = 0; id < f % 4; ++id) {
      frame.people.push_back(MakePerson(id, &random));
    }
  }
  return sequence;
}

// All data of tracks, with enough digits to distinguish any two numbers.
std::string TextOf(const TrackSequence& tracks, bool observations) {
  std::ostringstream text;
  text.precision(17);
  const TrackHeader& header = tracks.header;
  text << header.mode << header.frame_rate_hz << header.config_json;
  for (const std::string& view : header.view_names) {
    if (observations) text << view;
  }
  for (const TrackFrame& frame : tracks.frames) {
    text << "\n" << frame.frame << " " << frame.time;
    for (const PersonPose& person : frame.people) {
      text << "\nperson " << person.id.value();
      for (size_t j = 0; j < person.joints.size(); ++j) {
        text << " " << ToString(person.joints[j].status) << " "
             << person.joints[j].position_m.transpose() << " "
             << person.inlier_views.at(j) << " "
             << person.covariances.at(j).value_or(
                    Eigen::Matrix3d::Constant(-1.0));
      }
      EXPECT_EQ(person.matches.size(), observations ? 2u : 0u);
      if (observations) text << " score " << person.score;
      for (const ViewMatch& match : person.matches) {
        text << "\nmatch " << match.view_idx << " " << match.detection_idx;
        for (const auto& weight : match.weights) {
          text << " " << weight.value_or(-1.0);
        }
      }
    }
  }
  return text.str();
}

TEST(TrackWriter, ReadsBackBitForBit) {
  TrackSequence sequence = RandomSequence();
  const TemporaryFolder folder;
  const std::string path = folder.path() / "tracks.jsonl";
  for (const bool observations : {true, false}) {
    WriteTracks(path, sequence, {observations});
    const TrackSequence read = ReadTracks(path);
    EXPECT_TRUE(read.header.skeleton == sequence.header.skeleton);
    for (TrackFrame& frame : sequence.frames) {
      for (PersonPose& person : frame.people) {
        if (!observations) person.matches.clear();
      }
    }
    EXPECT_EQ(TextOf(sequence, observations), TextOf(read, observations));
  }
}

TEST(TrackWriter, WritesTheDocumentedFields) {
  TrackSequence sequence;
  sequence.header.skeleton = Skeleton("pair", {"a", "b"}, {{0, 1}});
  sequence.header.mode = "paper";
  sequence.header.frame_rate_hz = 25.0;
  sequence.header.config_json = "{ \"mode\" : \"paper\",\n \"x\": 1.50 }";
  sequence.header.view_names = {"cam0"};
  TrackFrame frame;
  frame.frame = 300;
  frame.time = 12'040'000'000;
  PersonPose person;
  person.id = TrackId(4);
  person.joints = {{{0.1, -0.0, 3.0}, JointStatus::kObserved}, {}};
  frame.people.push_back(person);
  sequence.frames.push_back(frame);
  const std::string header =
      R"({"kinegraph": 1, "units": {"length": "m", "time": "s"}, )"
      R"("skeleton": {"name": "pair", "joints": ["a", "b"], )"
      R"("bones": [[0, 1]]}, "mode": "paper", "frame_rate": 25, )"
      R"("config": {"mode":"paper","x":1.50}})"
      "\n";
  const std::string start =
      R"({"frame": 300, "time": 12.04, "people": [{"id": 4, )"
      R"("joints": [[0.1, -0.0, 3], null], "status": ["observed", "missing"])";
  const TemporaryFolder folder;
  const std::string path = folder.path() / "tracks.jsonl";
  WriteTracks(path, sequence);
  EXPECT_EQ(ReadTextFile(path), header + start + "}]}\n");

  PersonPose& full = sequence.frames[0].people[0];
  full.inlier_views = {3, 0};
  full.covariances.resize(2);
  full.covariances[0] = Eigen::Vector3d(1, 2, 3).asDiagonal().toDenseMatrix();
  full.matches.push_back({0, 2, {0.93, std::nullopt}});
  full.score = 0.5;
  WriteTracks(path, sequence, {true});
  const std::string written = ReadTextFile(path);
  EXPECT_NE(written.find(R"("views": ["cam0"], "config")"), std::string::npos);
  EXPECT_NE(
      written.find(
          start +
          R"(, "covariance": [[1, 0, 0, 2, 0, 3], null], "views": [3, 0], )"
          R"("score": 0.5, "matches": {"cam0": 2}, )"
          R"("weights": {"cam0": [0.93, null]}}]})"),
      std::string::npos)
      << written;
}

TEST(TrackWriter, FileAppearsOnlyInCommit) {
  const TrackSequence sequence = RandomSequence();
  const TemporaryFolder folder;
  const std::string path = folder.path() / "tracks.jsonl";
  {
    TrackWriter writer(path, sequence.header);
    writer.Write(sequence.frames[0]);
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  TrackWriter writer(path, sequence.header);
  for (const TrackFrame& frame : sequence.frames) writer.Write(frame);
  EXPECT_FALSE(std::filesystem::exists(path));
  writer.Commit();
  EXPECT_EQ(ReadTracks(path).frames.size(), 20u);
}

TEST(TrackWriter, RefusesInvalidTracks) {
  const TrackSequence good = RandomSequence();
  const TemporaryFolder folder;
  const std::string path = folder.path() / "tracks.jsonl";
  const auto write = [&](const auto& spoil, bool observations = false) {
    TrackSequence sequence = good;
    spoil(&sequence);
    WriteTracks(path, sequence, {observations});
  };
  const auto unknown_view = [](auto* s) {
    s->frames[1].people[0].matches[0].view_idx = 3;
  };
  const auto endless = [](auto* s) {
    s->frames[1].people[0].joints[0] = {{0.0, INFINITY, 0.0},
                                        JointStatus::kObserved};
  };
  const auto short_of_a_joint = [](auto* s) {
    s->frames[1].people[0].joints.pop_back();
  };
  EXPECT_THROW(write([](auto* s) { s->frames[3].frame = 6; }),
               std::logic_error);
  for (const char* config : {"{} {}", "[1]"}) {
    EXPECT_THROW(write([&](auto* s) { s->header.config_json = config; }),
                 std::logic_error);
  }
  EXPECT_THROW(write(short_of_a_joint), std::logic_error);
  EXPECT_NO_THROW(write(unknown_view));
  EXPECT_THROW(write(unknown_view, true), std::logic_error);
  EXPECT_THROW(write(endless), std::logic_error);
}

TEST(ReadTracks, UnknownKeysAreIgnored) {
  const TemporaryFolder folder;
  const std::string path = folder.Write(
      "tracks.jsonl",
      R"({"kinegraph": 1, "later": [], "later": 2, "skeleton": {"name": "s", )"
      R"("joints": ["a"], "bones": [], "colour": 1}, "frame_rate": 50})"
      "\r\n\n"
      R"({"frame": 5, "people": [{"id": 1, "joints": [[1, 2, 3]], )"
      R"("status": ["inferred"], "mood": "good", )"
      R"("matches": {"b": 1, "a": 0}}], "more": null})");
  const TrackSequence tracks = ReadTracks(path);
  ASSERT_EQ(tracks.frames.size(), 1u);
  EXPECT_EQ(tracks.frames[0].time, 100'000'000);  // by the frame rate
  // Views that are missing in the header are added in order.
  EXPECT_EQ(tracks.header.view_names, (std::vector<std::string>{"b", "a"}));
  EXPECT_EQ(tracks.frames[0].people[0].matches[1].view_idx, 1);
  EXPECT_EQ(tracks.frames[0].people[0].joints[0].status,
            JointStatus::kInferred);
}

}  // namespace
}  // namespace kinegraph
