// C3D and BVH of other programs, and what is refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "core/io/files/text_file.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/person_names.h"
#include "core/io/tracks/tracks.h"
#include "tests/core/io/input_error.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;
using testing::InputErrorOf;
using testing::TemporaryFolder;

// ---- C3D ----

// A file of two frames in another program's manner: integers or floats in one
// of three byte orders, two analog samples a frame, two subjects.
class C3dMaker {
 public:
  C3dMaker(int order, bool is_float) : order_(order), is_float_(is_float) {}

  std::string Make(const std::string& units = "mm") {
    text_.assign(512, '\0');
    text_[0] = 2;
    text_[1] = 0x50;
    PutWord(2, 3);   // points
    PutWord(4, 2);   // analog samples
    PutWord(6, 11);  // frames
    PutWord(8, 12);
    PutFloat(12, is_float_ ? -0.5 : 0.5);
    PutWord(16, 3);  // data
    PutFloat(20, 100.0);
    Parameters(units);
    for (int frame = 0; frame < 2; ++frame) {
      Point(100.0 + frame, -200.0, 300.0, 5);
      Point(10.0, 20.0, 30.0, frame == 0 ? 0 : -1);
      Point(-1000.0, 2000.0, -3000.0, 0x0102);
      Value(7.0);
      Value(8.0);
    }
    return text_;
  }

 private:
  void Word(int value) {
    const char low = static_cast<char>(value & 255);
    const char high = static_cast<char>(value >> 8 & 255);
    text_ += order_ == 86 ? high : low;
    text_ += order_ == 86 ? low : high;
  }
  void Float(double value) {
    // DEC's exponent counts two more.
    const auto number = static_cast<float>(order_ == 85 ? 4.0 * value : value);
    uint32_t bits = 0;
    std::memcpy(&bits, &number, 4);
    const auto high = static_cast<int>(bits >> 16);
    const auto low = static_cast<int>(bits & 0xFFFF);
    Word(order_ == 84 ? low : high);
    Word(order_ == 84 ? high : low);
  }
  void PutWord(size_t at, int value) {
    Put(at, [&] { Word(value); });
  }
  void PutFloat(size_t at, double value) {
    Put(at, [&] { Float(value); });
  }
  template <typename Append>
  void Put(size_t at, const Append& append) {
    const std::string before = std::move(text_);
    text_.clear();
    append();
    const std::string bytes = text_;
    text_ = before;
    text_.replace(at, bytes.size(), bytes);
  }
  void Value(double value) {
    if (is_float_) {
      Float(value);
    } else {
      Word(static_cast<int>(value));
    }
  }
  void Point(double x, double y, double z, int word) {
    for (const double mm : {x, y, z}) Value(is_float_ ? mm : mm / 0.5);
    Value(word);
  }
  void Record(int group, const std::string& name, const std::string& content) {
    text_ += static_cast<char>(name.size());
    text_ += static_cast<char>(group);
    text_ += name;
    Word(static_cast<int>(content.size()) + 2);
    text_ += content;
  }
  static std::string Texts(int width, const std::vector<std::string>& texts) {
    std::string content = {'\xFF', '\x02', static_cast<char>(width),
                           static_cast<char>(texts.size())};
    for (std::string text : texts) {
      text.resize(static_cast<size_t>(width), ' ');
      content += text;
    }
    return content + '\0';
  }
  void Parameters(const std::string& units) {
    text_ += std::string("\x01\x50\x01", 3) + static_cast<char>(order_);
    // Parameters may come before their group.
    Record(1, "LABELS", Texts(9, {"Anna:HEAD", "Ben:HEAD", "Ben:C7"}));
    Record(-1, "point", std::string("\x05words", 6));
    Record(1, "UNITS", Texts(4, {units}));
    text_.resize(1024, '\0');
  }

  const int order_;
  const bool is_float_;
  std::string text_;
};

TEST(TracksC3d, IntegersAndFloatsOfEveryByteOrder) {
  for (const int order : {84, 85, 86}) {
    for (const bool is_float : {false, true}) {
      const TemporaryFolder folder;
      const std::string path =
          folder.Write("walk.c3d", C3dMaker(order, is_float).Make());
      const TrackSequence tracks = ReadTracks(path);
      EXPECT_EQ(tracks.header.frame_rate_hz, 100.0) << order;
      EXPECT_EQ(tracks.header.skeleton.joints(),
                (std::vector<std::string>{"HEAD", "C7"}));
      ASSERT_EQ(tracks.frames.size(), 2u);
      EXPECT_EQ(tracks.frames[0].frame, 10) << "C3D counts from 1";
      EXPECT_EQ(tracks.frames[1].time, 110'000'000);
      ASSERT_EQ(tracks.frames[1].people.size(), 2u);
      const PersonPose& anna = tracks.frames[1].people[0];
      const PersonPose& ben = tracks.frames[1].people[1];
      // 101 mm is 202 steps of half a millimetre.
      EXPECT_LT((anna.joints[0].position_m - Vector3d(0.101, -0.2, 0.3)).norm(),
                1e-12);
      EXPECT_FALSE(anna.joints[1].present());
      EXPECT_FALSE(ben.joints[0].present()) << "residual -1";
      EXPECT_LT((ben.joints[1].position_m - Vector3d(-1.0, 2.0, -3.0)).norm(),
                1e-12);
      EXPECT_EQ(ReadPersonNames(path),
                (PersonNames{{TrackId(0), "Anna"}, {TrackId(1), "Ben"}}));
    }
  }
}

TEST(TracksC3d, UnitsAxesAndErrors) {
  const TemporaryFolder folder;
  const std::string path = folder.path() / "walk.c3d";
  const auto write = [&](const std::string& content) {
    std::ofstream(path, std::ios::binary) << content;
  };
  write(C3dMaker(84, true).Make("m"));
  TrackReadOptions options;
  options.axes = AxisMap::Parse("x,z,-y");
  EXPECT_EQ(ReadTracks(path, options).frames[0].people[0].joints[0].position_m,
            Vector3d(100.0, -300.0, -200.0));
  const auto error = [&] { return InputErrorOf([&] { ReadTracks(path); }); };
  write(C3dMaker(84, true).Make("inch"));
  EXPECT_THAT(error(), HasSubstr("walk.c3d: POINT:UNITS: found 'inch'"));
  const std::string whole = C3dMaker(84, true).Make();
  write(whole.substr(0, whole.size() - 1));
  EXPECT_THAT(error(), HasSubstr("is cut off"));
  std::string spoilt = whole;
  spoilt[512 + 3] = 83;
  write(spoilt);
  EXPECT_THAT(error(), HasSubstr("byte order"));
}

// A header's word ends at 65535. TRIAL counts on, and where a file has none the
// points' own count does.
TEST(TracksC3d, MoreFramesThanAWordCounts) {
  constexpr int64_t kFrames = 65600;
  TrackSequence tracks;
  tracks.header.skeleton = Skeleton("one", {"nose"}, {});
  tracks.header.frame_rate_hz = 100.0;
  for (int64_t f = 0; f < kFrames; ++f) {
    TrackFrame& frame = tracks.frames.emplace_back();
    frame.frame = f;
    frame.time = f * 10'000'000;
    PersonPose& person = frame.people.emplace_back();
    person.id = TrackId(4);
    person.joints = {{{1e-3 * static_cast<double>(f % 1000), 0.0, 1.0},
                      JointStatus::kObserved}};
  }
  const TemporaryFolder folder;
  const std::string path = folder.path() / "long.c3d";
  Losses losses;
  FindTrackFormat("c3d")->write(path, tracks, {{}, {{TrackId(4), "Anna"}}},
                                &losses);
  std::string bytes = ReadTextFile(path);
  // SUBJECTS:NAMES, and EVENT:SUBJECTS of the first and the last frame.
  int named = 0;
  for (size_t at = 0; (at = bytes.find("Anna", at)) != std::string::npos;
       ++at) {
    ++named;
  }
  EXPECT_EQ(named, 3);
  EXPECT_EQ(ReadTracks(path).frames.size(), static_cast<size_t>(kFrames));
  const size_t trial = bytes.find("TRIAL");
  ASSERT_NE(trial, std::string::npos);
  bytes.replace(trial, 5, "OTHER");
  std::ofstream(path, std::ios::binary) << bytes;
  EXPECT_EQ(ReadTracks(path).frames.size(), static_cast<size_t>(kFrames));
}

TEST(TracksC3d, AFrameIsANumber) {
  TrackSequence tracks;
  tracks.header.skeleton = Skeleton("one", {"nose"}, {});
  tracks.header.frame_rate_hz = 100.0;
  TrackFrame& frame = tracks.frames.emplace_back();
  PersonPose& person = frame.people.emplace_back();
  person.id = TrackId(0);
  person.joints = {{{1.0, 2.0, 3.0}, JointStatus::kObserved}};
  const TemporaryFolder folder;
  const std::string path = folder.path() / "a.c3d";
  Losses losses;
  FindTrackFormat("c3d")->write(path, tracks, {}, &losses);
  const std::string whole = ReadTextFile(path);
  // Type, number of sides, side, then two words: here one float instead.
  const std::string name = "ACTUAL_START_FIELD";
  const size_t at = whole.find(name) + name.size() + 2;
  ASSERT_EQ(whole.substr(at, 3), std::string("\x02\x01\x02"));
  for (const float number : {1.0f, NAN, -1.0f, 1e30f}) {
    std::string bytes = whole;
    bytes.replace(at, 3, "\x04\x01\x01");
    std::memcpy(&bytes[at + 3], &number, sizeof(number));
    std::ofstream(path, std::ios::binary) << bytes;
    if (number == 1.0f) {
      EXPECT_EQ(ReadTracks(path).frames.size(), 1u);
      continue;
    }
    EXPECT_THAT(
        InputErrorOf([&] { ReadTracks(path); }),
        HasSubstr("TRIAL:ACTUAL_START_FIELD: expected the number of a frame"));
  }
}

// ---- BVH ----

constexpr const char* kBvh =
    "HIERARCHY\r\n"
    "ROOT mixamorig:Hips\n{\n  OFFSET 1 2 3\n"
    "  CHANNELS 6 Xposition Yposition Zposition Yrotation Xrotation Zrotation\n"
    "  JOINT LeftUpLeg\n  {\n    OFFSET 10 0 0\n"
    "    CHANNELS 3 Zrotation Yrotation Xrotation\n"
    "    JOINT LeftLeg\n    {\n      OFFSET 0 -40 0\n"
    "      CHANNELS 3 Zrotation Yrotation Xrotation\n"
    "      End Site\n      {\n        OFFSET 0 -40 0\n      }\n    }\n  }\n"
    "  JOINT twist\n  {\n    OFFSET 0 0 0\n    CHANNELS 1 Yrotation\n"
    "    JOINT Neck\n    {\n      OFFSET 0 50 0\n      CHANNELS 0\n"
    "      End Site { OFFSET 0 1 0 }\n    }\n  }\n}\n"
    "MOTION\nFrames: 2\nFrame Time: 0.0333333\n";

TEST(TracksBvh, OtherProgramsChannelsAndNames) {
  const TemporaryFolder folder;
  const std::string path =
      folder.Write("dance.bvh", std::string(kBvh) +
                                    "0 100 0  90 0 0  0 0 0  0 0 0  0\n"
                                    "0 100 0  0 0 0  90 0 0  0 0 0  45\n");
  TrackReadOptions options;
  options.axes = AxisMap::Parse("x,y,z");
  const TrackSequence tracks = ReadTracks(path, options);
  EXPECT_EQ(tracks.header.frame_rate_hz, 30.0);
  EXPECT_EQ(tracks.header.skeleton.joints(),
            (std::vector<std::string>{"mid_hip", "l_hip", "l_knee", "neck"}));
  ASSERT_EQ(tracks.header.skeleton.bones().size(), 3u);
  EXPECT_EQ(tracks.header.skeleton.bones()[2].a, 0) << "past the pivot";
  ASSERT_EQ(tracks.frames.size(), 2u);
  const auto at = [&](size_t frame, size_t joint) {
    return tracks.frames[frame].people.at(0).joints.at(joint).position_m;
  };
  // The place takes the offset's place.
  EXPECT_LT((at(0, 0) - Vector3d(0.0, 1.0, 0.0)).norm(), 1e-12);
  // Turned about Y by 90 degrees, X points to -Z.
  EXPECT_LT((at(0, 1) - Vector3d(0.0, 1.0, -0.1)).norm(), 1e-12);
  EXPECT_LT((at(0, 2) - Vector3d(0.0, 0.6, -0.1)).norm(), 1e-12);
  // The thigh turned about Z by 90 degrees: -Y becomes X.
  EXPECT_LT((at(1, 2) - Vector3d(0.5, 1.0, 0.0)).norm(), 1e-12);
  EXPECT_LT((at(1, 3) - Vector3d(0.0, 1.5, 0.0)).norm(), 1e-12);
}

TEST(TracksBvh, ErrorsNameFileAndLine) {
  const TemporaryFolder folder;
  const auto error = [&](const std::string& content) {
    const std::string path = folder.Write("dance.bvh", content);
    return InputErrorOf([&] { ReadTracks(path); });
  };
  EXPECT_THAT(error(std::string(kBvh) + "0 1 2 3"),
              HasSubstr("dance.bvh: line 35: ends before a channel's value"));
  EXPECT_THAT(error("HIERARCHY\nROOT Hips\n{\nCHANNELS 2 Xposition Xscale"),
              HasSubstr("found 'Xscale', expected Xposition .. Zrotation"));
  EXPECT_THAT(error("HIERARCHY\nROOT Hips\n{\nOFFSET 0 nan 0"),
              HasSubstr("line 4: found 'nan'"));
  EXPECT_THAT(error("HIERARCHY\nROOT Hips\n{\n}\nMOTION\nFrames: 1e9\n"
                    "Frame Time: 0.01\n"),
              HasSubstr("Frames: expected 0 .. 10000000"));
}

// A rounded time means a whole rate; that of NTSC is a thousandth below.
TEST(TracksBvh, RatesOfRoundedTimes) {
  const TemporaryFolder folder;
  const auto rate_of = [&](const std::string& step_s) {
    return ReadTracks(folder.Write("a.bvh",
                                   "HIERARCHY\nROOT Hips\n{\nOFFSET 0 0 0\n"
                                   "CHANNELS 3 Xposition Yposition Zposition\n"
                                   "End Site\n{\nOFFSET 0 1 0\n}\n}\nMOTION\n"
                                   "Frames: 1\nFrame Time: " +
                                       step_s + "\n0 0 0\n"))
        .header.frame_rate_hz;
  };
  EXPECT_EQ(rate_of("0.0333333"), 30.0);
  EXPECT_EQ(rate_of("0.033333"), 30.0);
  EXPECT_EQ(rate_of("0.00833"), 120.0);
  EXPECT_NEAR(rate_of("0.03336666666666667"), 30000.0 / 1001.0, 1e-9);
  EXPECT_NEAR(rate_of("0.016683333333333335"), 60000.0 / 1001.0, 1e-9);
}

// What is written reads back where the rigid skeleton stands.
TEST(TracksBvh, OwnFilesComeBack) {
  TrackSequence tracks;
  tracks.header.skeleton = Coco17();
  tracks.header.frame_rate_hz = 25.0;
  for (int64_t f = 0; f < 20; ++f) {
    TrackFrame frame;
    frame.frame = f;
    PersonPose person;
    person.id = TrackId(4);
    const double turn = 0.1 * static_cast<double>(f);
    for (size_t j = 0; j < 17; ++j) {
      // A rigid body that turns and walks.
      const double angle = 2.0 * static_cast<double>(j);
      const Vector3d still(std::cos(angle), std::sin(1.3 * angle),
                           0.1 * static_cast<double>(j));
      person.joints.push_back(
          {{turn + std::cos(turn) * still.x() - std::sin(turn) * still.y(),
            std::sin(turn) * still.x() + std::cos(turn) * still.y(), still.z()},
           JointStatus::kObserved});
    }
    frame.people = {person};
    tracks.frames.push_back(frame);
  }
  const TemporaryFolder folder;
  Losses losses;
  FindTrackFormat("bvh")->write(folder.path() / "bvh", tracks,
                                {{}, {{TrackId(4), "Anna"}}}, &losses);
  EXPECT_THAT(losses, ::testing::Contains(HasSubstr(
                          "joints lie 0.0 mm (RMS) and at most 0.0 mm")));
  const std::string path = folder.path() / "bvh";
  EXPECT_EQ(ReadPersonNames(path), (PersonNames{{TrackId(4), "Anna"}}));
  const TrackSequence read = ReadTracks(path);
  ASSERT_EQ(read.frames.size(), 20u);
  for (size_t f = 0; f < 20; ++f) {
    const PersonPose& person = read.frames[f].people.at(0);
    EXPECT_EQ(person.id, TrackId(4));
    for (size_t j = 0; j < 17; ++j) {
      const int at = read.header.skeleton.IndexOf(Coco17().joints()[j]);
      ASSERT_GE(at, 0) << Coco17().joints()[j];
      // Six digits of centimetres and degrees along four bones of a metre.
      EXPECT_LT((person.joints[static_cast<size_t>(at)].position_m -
                 tracks.frames[f].people[0].joints[j].position_m)
                    .norm(),
                5e-7);
    }
  }
}

}  // namespace
}  // namespace kinegraph
