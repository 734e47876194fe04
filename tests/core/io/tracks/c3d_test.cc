// C3D files of other programs: byte orders, every convention for the number of
// frames, missing points, people, segments, force plates, rejections; and files
// that kinegraph writes.
#include "core/io/tracks/c3d.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "core/io/files/text_file.h"
#include "tests/core/io/input_error.h"
#include "tests/core/io/tracks/recordings.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;
using testing::InputErrorOf;
using testing::TemporaryFolder;

constexpr int kIntel = 84;
constexpr int kDec = 85;
constexpr int kMips = 86;

// Makes files as other programs do: parameters come before their groups.
class C3dMaker {
 public:
  explicit C3dMaker(int order = kIntel, bool is_float = true)
      : order_(order), is_float_(is_float), scale_(is_float ? -1.0 : 0.5) {}

  C3dMaker& Header(int points, int first, int last) {
    points_ = points;
    first_ = first;
    last_ = last;
    return *this;
  }
  // Analog values per frame, with `samples` samples of each channel.
  C3dMaker& Analog(int values, int samples = 0) {
    analog_ = values;
    samples_ = samples;
    return *this;
  }
  C3dMaker& Rate(double hz) {
    rate_hz_ = hz;
    return *this;
  }
  C3dMaker& Scale(double scale) {
    scale_ = scale;
    return *this;
  }
  C3dMaker& Words(const std::string& name, const std::vector<int>& values,
                  std::vector<size_t> sides = {}) {
    std::string data;
    for (const int value : values) data += Word(value);
    if (sides.empty() && values.size() > 1) sides = {values.size()};
    return Add(name, '\x02', sides, data);
  }
  C3dMaker& Number(const std::string& name, double value) {
    return Add(name, '\x04', {}, Float(value));
  }
  C3dMaker& Texts(const std::string& name,
                  const std::vector<std::string>& texts) {
    size_t width = 1;
    for (const std::string& text : texts) width = std::max(width, text.size());
    std::string data;
    for (std::string text : texts) {
      text.resize(width, ' ');
      data += text;
    }
    return Add(name, '\xFF', {width, texts.size()}, data);
  }
  C3dMaker& Labels(const std::vector<std::string>& labels) {
    return Texts("POINT:LABELS", labels);
  }
  // Adds a point in the file's unit; `word`: camera mask and residual.
  C3dMaker& Point(double x, double y, double z, int word = 0) {
    for (const double value : {x, y, z}) Value(is_float_ ? value : value / 0.5);
    return Value(word);
  }
  C3dMaker& Value(double value) {
    data_ += is_float_ ? Float(value) : Word(static_cast<int>(value));
    return *this;
  }
  C3dMaker& Raw(const std::string& bytes) {
    data_ += bytes;
    return *this;
  }
  // Adds a segment: rotation by columns, origin and reliability.
  C3dMaker& Matrix(const Eigen::Matrix4d& matrix, double reliability) {
    for (int i = 0; i < 16; ++i) data_ += Float(matrix(i % 4, i / 4));
    data_ += Float(reliability);
    return *this;
  }
  // Pads the data to the next block.
  C3dMaker& Pad() {
    data_.resize((data_.size() + 511) / 512 * 512, '\0');
    return *this;
  }

  std::string Make() const {
    std::string text = {'\x02', '\x50'};
    text += Word(points_) + Word(analog_) + Word(first_) + Word(last_);
    text += Word(0) + Float(scale_) + Word(kDataBlock) + Word(samples_);
    text += Float(rate_hz_);
    text.resize(512, '\0');
    text += {'\x01', '\x50', '\x02', static_cast<char>(order_)};
    std::map<std::string, int> groups;
    for (const auto& [name, content] : parameters_) {
      const size_t colon = name.find(':');
      const int group =
          groups.try_emplace(name.substr(0, colon), groups.size() + 1)
              .first->second;
      text += Record(group, name.substr(colon + 1), content);
    }
    for (const auto& [name, group] : groups) {
      text += Record(-group, name, std::string("\x05words", 6));
    }
    text.resize(512 * (kDataBlock - 1), '\0');
    return text + data_;
  }

 private:
  static constexpr int kDataBlock = 4;

  C3dMaker& Add(const std::string& name, char type,
                const std::vector<size_t>& sides, const std::string& data) {
    std::string content = {type, static_cast<char>(sides.size())};
    for (const size_t side : sides) content += static_cast<char>(side);
    parameters_.emplace_back(name, content + data + '\0');
    return *this;
  }
  std::string Word(int value) const {
    const char low = static_cast<char>(value & 255);
    const char high = static_cast<char>(value >> 8 & 255);
    return order_ == kMips ? std::string{high, low} : std::string{low, high};
  }
  std::string Float(double value) const {
    // The exponent of DEC's floats is larger by two.
    const auto number =
        static_cast<float>(order_ == kDec ? 4.0 * value : value);
    uint32_t bits = 0;
    std::memcpy(&bits, &number, 4);
    const auto high = static_cast<int>(bits >> 16);
    const auto low = static_cast<int>(bits & 0xFFFF);
    return order_ == kIntel ? Word(low) + Word(high) : Word(high) + Word(low);
  }
  std::string Record(int group, const std::string& name,
                     const std::string& content) const {
    return static_cast<char>(name.size()) + (static_cast<char>(group) + name) +
           Word(static_cast<int>(content.size()) + 2) + content;
  }

  const int order_;
  const bool is_float_;
  int points_ = 0;
  int analog_ = 0;
  int samples_ = 0;
  int first_ = 1;
  int last_ = 0;
  double scale_;
  double rate_hz_ = 100.0;
  std::vector<std::pair<std::string, std::string>> parameters_;
  std::string data_;
};

// One point in `count` frames; in frame f it is at x = f + 1 mm.
C3dMaker OnePoint(int first, int last, int count) {
  C3dMaker maker;
  maker.Header(1, first, last).Labels({"nose"});
  for (int f = 0; f < count; ++f) maker.Point(f + 1, 20.0, 30.0);
  return maker;
}

// Specifies the frames from `start` to `end`, as two words each.
C3dMaker Trial(C3dMaker maker, int start, int end) {
  return maker.Words("TRIAL:ACTUAL_START_FIELD", {start & 0xFFFF, start >> 16})
      .Words("TRIAL:ACTUAL_END_FIELD", {end & 0xFFFF, end >> 16});
}

class TracksC3d : public ::testing::Test {
 protected:
  std::string Put(const std::string& bytes) const {
    const std::string path = folder_.path() / "walk.c3d";
    std::ofstream(path, std::ios::binary) << bytes;
    return path;
  }
  TrackSequence Read(const C3dMaker& maker) const {
    return ReadTracks(Put(maker.Make()));
  }
  size_t Count(const C3dMaker& maker) const {
    return Read(maker).frames.size();
  }
  int64_t First(const C3dMaker& maker) const {
    return Read(maker).frames.front().frame;
  }
  std::string ErrorOf(const C3dMaker& maker) const {
    return InputErrorOf([&] { Read(maker); });
  }

  const TemporaryFolder folder_;
};

C3dMaker TwoPeople(int order, bool is_float) {
  C3dMaker maker(order, is_float);
  maker.Header(3, 11, 12).Analog(2);
  maker.Labels({"Anna:HEAD", "Ben:HEAD", "Ben:C7"})
      .Texts("POINT:UNITS", {"mm"});
  for (int frame = 0; frame < 2; ++frame) {
    maker.Point(100.0 + frame, -200.0, 300.0, 5);
    maker.Point(10.0, 20.0, 30.0, frame == 0 ? 0 : -1);
    maker.Point(-1000.0, 2000.0, -3000.0, 0x0102);
    maker.Value(7.0).Value(8.0);
  }
  return maker;
}

TEST_F(TracksC3d, ReadsIntegersAndFloatsOfEveryByteOrder) {
  for (const int order : {kIntel, kDec, kMips}) {
    for (const bool is_float : {false, true}) {
      const TrackSequence tracks = Read(TwoPeople(order, is_float));
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
      EXPECT_EQ(ReadPersonNames(folder_.path() / "walk.c3d"),
                (PersonNames{{TrackId(0), "Anna"}, {TrackId(1), "Ben"}}));
    }
  }
}

TEST_F(TracksC3d, UnitsAndAxesAreAppliedAndErrorsNameTheFile) {
  const auto in = [](const std::string& unit) {
    return OnePoint(1, 2, 2).Texts("POINT:UNITS", {unit});
  };
  for (const auto& [unit, metres] : std::vector<std::pair<std::string, double>>{
           {"mm", 1e-3}, {"", 1e-3}, {"MM", 1e-3}, {"cm", 1e-2}, {"m", 1.0}}) {
    EXPECT_EQ(Read(in(unit)).frames[1].people[0].joints[0].position_m,
              metres * Vector3d(2.0, 20.0, 30.0))
        << unit;
  }
  TrackReadOptions options;
  options.axes = AxisMap::Parse("x,z,-y");
  const TrackSequence turned = ReadTracks(Put(in("m").Make()), options);
  EXPECT_EQ(turned.frames[0].people[0].joints[0].position_m,
            Vector3d(1.0, -30.0, 20.0));
  EXPECT_EQ(InputErrorOf([] { ReadForcePlates("/nowhere.c3d"); }),
            "/nowhere.c3d: cannot be read: No such file or directory");
  EXPECT_THAT(ErrorOf(in("inch")),
              HasSubstr("walk.c3d: POINT:UNITS: found 'inch'"));
  const std::string whole = in("mm").Make();
  Put(whole.substr(0, whole.size() - 1));
  const auto error = [&] {
    return InputErrorOf([&] { ReadTracks(folder_.path() / "walk.c3d"); });
  };
  EXPECT_THAT(error(), HasSubstr("is cut off"));
  std::string spoilt = whole;
  spoilt[512 + 3] = 83;
  Put(spoilt);
  EXPECT_THAT(error(), HasSubstr("byte order"));
}

// ---- Number of frames ----

TEST_F(TracksC3d, ReadsEveryConventionForLongFiles) {
  constexpr int kLong = 66'000;
  constexpr int kRunOver = kLong - 65536;
  const C3dMaker full = OnePoint(1, 65535, kLong);
  const C3dMaker over =
      OnePoint(1, kRunOver, kLong).Words("POINT:FRAMES", {kRunOver});
  const auto frames = [&](int words) {
    return C3dMaker(full).Words("POINT:FRAMES", {words});
  };
  std::map<std::string, C3dMaker> files = {
      {"header alone", full},
      {"-1", frames(-1)},
      {"-1 as float", C3dMaker(full).Number("POINT:FRAMES", -1.0)},
      {"run over", over},
      {"float", C3dMaker(full).Number("POINT:FRAMES", kLong)},
      {"LONG_FRAMES", frames(65535).Number("POINT:LONG_FRAMES", kLong)},
      {"TRIAL", Trial(frames(65535), 1, kLong)},
      {"TRIAL full, too", Trial(full, 1, 65535)},
      {"TRIAL beside words that ran over", Trial(over, 1, kLong)}};
  for (auto& [name, maker] : files) {
    for (const bool is_padded : {false, true}) {
      if (is_padded) maker.Pad();
      const TrackSequence tracks = Read(maker);
      ASSERT_EQ(tracks.frames.size(), static_cast<size_t>(kLong))
          << name << is_padded;
      EXPECT_EQ(tracks.frames.back().frame, kLong - 1);
      EXPECT_EQ(tracks.frames.back().people[0].joints[0].position_m.x(),
                0.001 * kLong);
    }
  }
}

TEST_F(TracksC3d, FindsFrameCountsNearTheLimitOfAWord) {
  for (const int count : {65534, 65535, 65536}) {
    const int last = std::min(count, 65535);
    C3dMaker maker = OnePoint(1, last, count);
    maker.Words("POINT:FRAMES", {last});
    EXPECT_EQ(Count(maker), static_cast<size_t>(count));
    EXPECT_EQ(Count(maker.Pad()), static_cast<size_t>(count));
  }
  EXPECT_THAT(ErrorOf(OnePoint(1, 65535, 60'000)), HasSubstr("is cut off"))
      << "a full word means 65535 or more";
}

TEST_F(TracksC3d, FileSizeResolvesContradictoryFrameCounts) {
  const auto frames = [](int first, int last, int words) {
    return OnePoint(first, last, 90).Words("POINT:FRAMES", {words}).Pad();
  };
  // The header has no number: the parameters specify it.
  EXPECT_EQ(Count(frames(0, 0, 90)), 90u);
  EXPECT_EQ(First(frames(5, 0, 90)), 4);
  // FRAMES = 0: the header specifies it.
  EXPECT_EQ(Count(frames(1, 90, 0)), 90u);
  // Neither specifies it: the frames extend to the end of the file.
  EXPECT_EQ(Count(OnePoint(0, 0, 90)), 90u);
  // The header, or FRAMES, has the number of frames before the recording was
  // trimmed.
  EXPECT_EQ(Count(frames(1, 500, 90)), 90u);
  EXPECT_EQ(Count(frames(1, 90, 500)), 90u);
  // One block more than stated is consistent.
  EXPECT_EQ(Count(OnePoint(1, 90, 90).Pad().Raw(std::string(512, '\7'))), 90u);
  EXPECT_THAT(
      ErrorOf(OnePoint(1, 200, 90).Words("POINT:FRAMES", {300})),
      HasSubstr("specifies 300 frames (POINT:FRAMES) and 200 frames (the "
                "header), but has space for 90"));
  EXPECT_THAT(ErrorOf(OnePoint(1, 200, 90).Words("POINT:FRAMES", {200})),
              HasSubstr("is cut off"));
}

TEST_F(TracksC3d, FirstFrameComesFromHeaderOrTrial) {
  EXPECT_EQ(First(OnePoint(101, 150, 50)), 100) << "a trimmed file";
  EXPECT_EQ(First(OnePoint(0, 49, 50)), 0) << "a writer that counts from 0";
  EXPECT_EQ(First(Trial(OnePoint(1, 50, 50), 101, 150)), 100);
  EXPECT_EQ(First(Trial(OnePoint(65535, 65535, 50).Words("POINT:FRAMES", {50}),
                        70'001, 70'050)),
            70'000);
  // If TRIAL or the header was not trimmed with the file, its count does not
  // fit.
  for (const C3dMaker& maker : {Trial(OnePoint(101, 150, 50), 1, 500),
                                Trial(OnePoint(1, 500, 50), 101, 150)}) {
    EXPECT_EQ(Count(maker), 50u);
    EXPECT_EQ(First(maker), 100);
  }
}

TEST_F(TracksC3d, RefusesInvalidStartFields) {
  for (const double number : {1.0, static_cast<double>(NAN), -1.0, 1e30}) {
    C3dMaker maker = OnePoint(1, 90, 90);
    maker.Number("TRIAL:ACTUAL_START_FIELD", number);
    maker.Number("TRIAL:ACTUAL_END_FIELD", 90.0);
    if (number == 1.0) {
      EXPECT_EQ(Count(maker), 90u);
      continue;
    }
    EXPECT_THAT(
        ErrorOf(maker),
        HasSubstr("TRIAL:ACTUAL_START_FIELD: expected the number of a frame"));
  }
}

TEST_F(TracksC3d, RateScaleAndPointsComeFromParametersOrHeader) {
  const auto rate = [&](const C3dMaker& maker) {
    return Read(maker).header.frame_rate_hz;
  };
  EXPECT_EQ(rate(OnePoint(1, 9, 9).Rate(0.0).Number("POINT:RATE", 59.94)),
            static_cast<double>(59.94F));
  EXPECT_EQ(rate(OnePoint(1, 9, 9).Rate(0.0)), 0.0)
      << "0: unknown, as in other formats";
  const C3dMaker unscaled = OnePoint(1, 9, 9).Scale(0.0);
  EXPECT_EQ(Count(C3dMaker(unscaled).Number("POINT:SCALE", -1.0)), 9u);
  EXPECT_THAT(ErrorOf(unscaled), HasSubstr("POINT:SCALE"));
  // The data are floats, regardless of the scale's sign.
  const TrackSequence floats = Read(OnePoint(1, 90, 90).Scale(0.5).Pad());
  ASSERT_EQ(floats.frames.size(), 90u);
  EXPECT_EQ(floats.frames[89].people[0].joints[0].position_m,
            0.001 * Vector3d(90.0, 20.0, 30.0));
  const auto used = [](int points) {
    return OnePoint(1, 90, 90).Words("POINT:USED", {points});
  };
  EXPECT_EQ(Count(used(1).Header(0, 1, 90)), 90u);
  EXPECT_EQ(Count(used(0)), 90u);
  EXPECT_EQ(Count(used(7).Pad()), 90u);
  EXPECT_THAT(ErrorOf(C3dMaker().Header(0, 1, 90).Analog(4)),
              HasSubstr("has no points"));
}

// ---- missing points ----

TEST_F(TracksC3d, ResidualsZerosAndNanMarkMissingPoints) {
  for (const bool is_float : {true, false}) {
    C3dMaker maker(kIntel, is_float);
    maker.Header(2, 1, 4).Labels({"nose", "l_hip"});
    for (const auto& [x, word] : std::vector<std::pair<double, int>>{
             {0.0, 0}, {0.0, 3}, {1.0, 0}, {1.0, -1}}) {
      maker.Point(x, 0.0, 0.0, word).Point(1.0, 2.0, 3.0);
    }
    const TrackSequence tracks = Read(maker);
    const auto is_there = [&](size_t f) {
      return tracks.frames[f].people[0].joints[0].present();
    };
    EXPECT_FALSE(is_there(0)) << "0, 0, 0 with residual 0";
    EXPECT_TRUE(is_there(1)) << "measured at the origin";
    EXPECT_TRUE(is_there(2));
    EXPECT_FALSE(is_there(3)) << "residual -1";
  }
  C3dMaker maker;
  maker.Header(2, 1, 4).Labels({"nose", "l_hip"});
  maker.Point(NAN, 0.0, 0.0).Point(1.0, 2.0, 3.0);
  maker.Point(1.0, INFINITY, 0.0).Point(1.0, 2.0, 3.0);
  // Among floats, the fourth number may be -1 as one or two 16-bit words.
  for (const char* word : {"\xFF\xFF\0\0", "\xFF\xFF\xFF\xFF"}) {
    maker.Value(1.0).Value(1.0).Value(1.0).Raw(std::string(word, 4));
    maker.Point(1.0, 2.0, 3.0);
  }
  for (const TrackFrame& frame : Read(maker).frames) {
    EXPECT_FALSE(frame.people[0].joints[0].present()) << frame.frame;
    EXPECT_TRUE(frame.people[0].joints[1].present());
  }
}

// ---- labels and people ----

TrackSequence ReadLabels(const TemporaryFolder& folder, C3dMaker maker,
                         const std::vector<std::string>& labels) {
  maker.Header(static_cast<int>(labels.size()), 1, 1);
  if (!labels.empty()) maker.Labels(labels);
  for (size_t i = 0; i < labels.size(); ++i) {
    maker.Point(1.0 + static_cast<double>(i), 0.0, 0.0);
  }
  return ReadTracks(folder.Write("labels.c3d", maker.Make()));
}

using Names = std::vector<std::string>;

TEST_F(TracksC3d, LabelsOfAnyKindGiveUniqueJoints) {
  const auto joints = [&](const Names& labels) {
    return ReadLabels(folder_, C3dMaker(), labels).header.skeleton.joints();
  };
  EXPECT_EQ(joints({"C7  ", "", "*12", "L"}), (Names{"C7", "L"}));
  EXPECT_EQ(joints({"C7", "L", "C7", "C7_2"}),
            (Names{"C7", "L", "C7_3", "C7_2"}))
      << "a label twice";
  EXPECT_EQ(joints({"", ""}), (Names{"point_1", "point_2"}));
  EXPECT_EQ(joints({"*1", "*2"}), (Names{"point_1", "point_2"}));
  EXPECT_EQ(joints({"Fu\xDF", "Fu\xC3\x9F l"}),
            (Names{"Fu\xC3\x9F", "Fu\xC3\x9F l"}))
      << "Latin-1 and UTF-8 in one file";
}

TEST_F(TracksC3d, ModelOutputsAreNotJoints) {
  const C3dMaker maker = C3dMaker()
                             .Texts("POINT:ANGLES", {"LHipAngles"})
                             .Texts("POINT:POWERS", {"LHipPower"})
                             .Number("POINT:FORCES", 1.0);
  EXPECT_EQ(ReadLabels(folder_, maker, {"LHipAngles", "LKNE", "LHipPower"})
                .header.skeleton.joints(),
            Names{"LKNE"});
  EXPECT_THAT(
      InputErrorOf([&] { ReadLabels(folder_, maker, {"LHipAngles"}); }),
      HasSubstr("has angles or other results of a model, but no points"));
}

// Every person gets an entry for every joint, which would need far more memory
// than the file.
TEST_F(TracksC3d, RefusesManyPeopleWithoutJointsInCommon) {
  Names labels;
  for (int i = 0; i < 65; ++i) {
    labels.push_back("A" + std::to_string(i) + ":B" + std::to_string(i));
  }
  EXPECT_THAT(InputErrorOf([&] { ReadLabels(folder_, C3dMaker(), labels); }),
              HasSubstr("has 65 people and 65 joints in all"));
  labels.pop_back();
  EXPECT_EQ(ReadLabels(folder_, C3dMaker(), labels).frames[0].people.size(),
            64u);
}

TEST_F(TracksC3d, ReadsMoreLabelsThanFitIntoAParameter) {
  constexpr int kPoints = 600;
  C3dMaker maker;
  maker.Header(kPoints, 1, 1);
  int label = 0;
  for (const char* name : {"POINT:LABELS", "POINT:LABELS2", "POINT:LABELS3"}) {
    Names part;
    while (part.size() < 255 && label < kPoints) {
      std::string text(1, static_cast<char>('A' + label / 36));
      text += "0123456789abcdefghijklmnopqrstuvwxyz"[label++ % 36];
      part.push_back(text);
    }
    maker.Texts(name, part);
  }
  for (int p = 0; p < kPoints; ++p) maker.Point(p + 1, 0.0, 0.0);
  const TrackSequence tracks = ReadTracks(Put(maker.Make()));
  ASSERT_EQ(tracks.header.skeleton.joints().size(), 600u);
  EXPECT_EQ(tracks.frames[0].people[0].joints[599].position_m.x(), 0.6);
}

TEST_F(TracksC3d, PrefixesAndRepeatedLabelsSeparatePeople) {
  const auto people = [&](const C3dMaker& maker, const Names& labels) {
    const TrackSequence tracks = ReadLabels(folder_, maker, labels);
    std::string text;
    for (const PersonPose& person : tracks.frames[0].people) {
      text += std::to_string(person.id.value()) + ":";
      for (size_t j = 0; j < person.joints.size(); ++j) {
        if (!person.joints[j].present()) continue;
        text += " " + tracks.header.skeleton.joints()[j];
      }
      text += "; ";
    }
    for (const auto& [id, name] :
         ReadPersonNames(folder_.path() / "labels.c3d")) {
      text += name + " ";
    }
    return text;
  };
  EXPECT_EQ(people(C3dMaker(), {"A:C7", "B:C7", "B:L"}),
            "0: C7; 1: C7 L; A B ");
  EXPECT_EQ(people(C3dMaker(), {"person_4:C7", "person_9:C7"}),
            "4: C7; 9: C7; ");
  // Vicon's prefixes need no colon.
  EXPECT_EQ(people(C3dMaker()
                       .Texts("SUBJECTS:LABEL_PREFIXES", {"A_", "B_"})
                       .Texts("SUBJECTS:NAMES", {"Anna", "Ben"})
                       .Words("SUBJECTS:USES_PREFIXES", {1}),
                   {"A_C7", "B_C7"}),
            "0: C7; 1: C7; Anna Ben ");
  // The only person is none of the listed ones.
  EXPECT_EQ(people(C3dMaker()
                       .Texts("SUBJECTS:LABEL_PREFIXES", {"A_"})
                       .Texts("SUBJECTS:NAMES", {"Anna", "Ben"})
                       .Words("SUBJECTS:USES_PREFIXES", {1}),
                   {"Carl:C7"}),
            "0: C7; Carl ");
  // A file without prefixes, with a colon in the name of a joint.
  const C3dMaker anna = C3dMaker()
                            .Texts("SUBJECTS:NAMES", {"Anna"})
                            .Words("SUBJECTS:USES_PREFIXES", {0});
  EXPECT_EQ(people(anna, {"rig:Hips", "rig:Head"}),
            "0: rig:Hips rig:Head; Anna ");
  EXPECT_EQ(people(anna, {"Anna:Hips"}), "0: Hips; Anna ");
  // The same labels for all people.
  EXPECT_EQ(people(C3dMaker(), {"C7", "L", "C7", "L"}), "0: C7 L; 1: C7 L; ");
  EXPECT_EQ(people(C3dMaker().Texts("SUBJECTS:NAMES", {"Anna", "Ben"}),
                   {"C7", "L", "C7", "L"}),
            "0: C7 L; 1: C7 L; Anna Ben ");
}

// ---- segments ----

TEST_F(TracksC3d, SegmentsHavePosesAndOriginsAreJoints) {
  Eigen::Matrix4d shank = Eigen::Matrix4d::Identity();
  shank.topLeftCorner<3, 3>() =
      Eigen::AngleAxisd(0.5, Vector3d::UnitX()).toRotationMatrix();
  shank.topRightCorner<3, 1>() = Vector3d(100.0, 200.0, 500.0);
  Eigen::Matrix4d moved = shank;
  moved(0, 3) = 101.0;
  for (const int order : {kIntel, kDec, kMips}) {
    for (const int ratio : {1, 2}) {
      C3dMaker maker(order);
      maker.Header(0, 11, 12).Words("POINT:USED", {0});
      maker.Words("ROTATION:USED", {2}).Words("ROTATION:DATA_START", {4});
      maker.Number("ROTATION:RATE", 100.0 * ratio);
      maker.Words("ROTATION:RATIO", {ratio});
      maker.Texts("ROTATION:LABELS", {"worldbody_4X4", "l_shank_4X4"});
      for (int f = 0; f < 2 * ratio; ++f) {
        maker.Matrix(Eigen::Matrix4d::Identity(), 0.0);
        maker.Matrix(f % 2 == 0 ? shank : moved, f == 1 ? -1.0 : 0.0);
      }
      const TrackSequence tracks = Read(maker.Pad());
      EXPECT_EQ(tracks.header.skeleton.joints(), Names{"l_shank"})
          << "the laboratory's segment is skipped";
      EXPECT_EQ(tracks.header.frame_rate_hz, 100.0 * ratio);
      ASSERT_EQ(tracks.frames.size(), 2u * static_cast<size_t>(ratio));
      EXPECT_EQ(tracks.frames[0].frame, 10 * ratio);
      EXPECT_LT((tracks.frames[0].people[0].joints[0].position_m -
                 Vector3d(0.1, 0.2, 0.5))
                    .norm(),
                1e-12);
      EXPECT_TRUE(tracks.frames[1].people.empty()) << "reliability -1";

      const SegmentSequence segments =
          ReadSegments(folder_.path() / "walk.c3d", AxisMap::Parse("x,z,-y"));
      EXPECT_EQ(segments.names, (Names{"worldbody", "l_shank"}));
      ASSERT_TRUE(segments.frames[0].world_from_segment[1].has_value());
      const Eigen::Isometry3d& pose = *segments.frames[0].world_from_segment[1];
      // The file's Y is up: world (x, y, z) = file (X, -Z, Y). Floats represent
      // a rotation to half a unit in the last place.
      const Vector3d z_of_segment = shank.block<3, 1>(0, 2);
      EXPECT_LT(
          (pose.linear().col(2) -
           Vector3d(z_of_segment.x(), -z_of_segment.z(), z_of_segment.y()))
              .norm(),
          1e-7);
      EXPECT_LT((pose.translation() - Vector3d(0.1, -0.5, 0.2)).norm(), 1e-12);
      EXPECT_FALSE(segments.frames[1].world_from_segment[1].has_value());
    }
  }
}

// Channel c contains c newtons. Each plate has a row of eight channels, of
// which types 1, 2 and 4 use the first six.
TEST_F(TracksC3d, ReadsLoadsOfForcePlatesOfEveryType) {
  const std::vector<std::pair<int, std::pair<double, double>>> loads = {
      {1, {3.0, 11.0}}, {2, {3.0, 11.0}}, {3, {26.0, 58.0}}, {4, {3.0, 11.0}}};
  std::vector<int> channels;
  for (int c = 1; c <= 16; ++c) channels.push_back(c);
  for (const auto& [type, load_n] : loads) {
    C3dMaker maker;
    maker.Header(1, 1, 2).Analog(16, 1).Labels({"nose"});
    maker.Words("FORCE_PLATFORM:USED", {2})
        .Words("FORCE_PLATFORM:TYPE", {type, type})
        .Words("FORCE_PLATFORM:CHANNEL", channels, {8, 2});
    for (int frame = 0; frame < 2; ++frame) {
      maker.Point(10.0, 20.0, 30.0);
      for (const int c : channels) maker.Value(c);
    }
    const auto plates = ReadForcePlates(Put(maker.Make()));
    ASSERT_EQ(plates.size(), 2u) << type;
    EXPECT_EQ(plates[0].load_n, std::vector<double>(2, load_n.first)) << type;
    EXPECT_EQ(plates[1].load_n, std::vector<double>(2, load_n.second)) << type;
  }
}

TEST_F(TracksC3d, NamesTheNumberOfAnAnalogChannelThatDoesNotExist) {
  for (const int number : {0, 7, 99}) {
    C3dMaker maker;
    maker.Header(1, 1, 2).Analog(6, 1).Labels({"nose"});
    maker.Words("FORCE_PLATFORM:USED", {1})
        .Words("FORCE_PLATFORM:TYPE", {1})
        .Words("FORCE_PLATFORM:CHANNEL", {1, 2, number, 4, 5, 6}, {6, 1});
    for (int frame = 0; frame < 2; ++frame) {
      maker.Point(10.0, 20.0, 30.0);
      for (int c = 1; c <= 6; ++c) maker.Value(c);
    }
    const std::string path = Put(maker.Make());
    EXPECT_THAT(InputErrorOf([&] { ReadForcePlates(path); }),
                HasSubstr("plate 1: entry 3 is " + std::to_string(number) +
                          ", expected an analog channel from 1 to 6"));
  }
}

TEST_F(TracksC3d, RefusesForcePlatesWithoutAFrameRate) {
  C3dMaker maker;
  maker.Rate(0.0).Header(1, 1, 1).Analog(6, 1).Labels({"nose"});
  maker.Words("FORCE_PLATFORM:USED", {1})
      .Words("FORCE_PLATFORM:TYPE", {1})
      .Words("FORCE_PLATFORM:CHANNEL", {1, 2, 3, 4, 5, 6}, {6, 1});
  maker.Point(10.0, 20.0, 30.0);
  for (int c = 1; c <= 6; ++c) maker.Value(c);
  const std::string path = Put(maker.Make());
  EXPECT_THAT(InputErrorOf([&] { ReadForcePlates(path); }),
              HasSubstr("POINT:RATE: not given"));
}

// A sample of 32777 less an offset of 32767, times 3 and 0.5. Signed, 32777 is
// -32759; loads are made positive.
TEST_F(TracksC3d, AnalogSamplesHaveFormatOffsetAndScales) {
  for (const auto& [format, load_n] :
       {std::pair{"UNSIGNED", 15.0}, {"SIGNED", 98289.0}}) {
    C3dMaker maker(kIntel, /*is_float=*/false);
    maker.Header(1, 1, 2).Analog(6, 1).Labels({"nose"});
    maker.Texts("ANALOG:FORMAT", {format})
        .Words("ANALOG:OFFSET", {0, 0, 32767, 0, 0, 0})
        .Words("ANALOG:SCALE", {1, 1, 3, 1, 1, 1})
        .Number("ANALOG:GEN_SCALE", 0.5)
        .Words("FORCE_PLATFORM:USED", {1})
        .Words("FORCE_PLATFORM:TYPE", {1})
        .Words("FORCE_PLATFORM:CHANNEL", {1, 2, 3, 4, 5, 6}, {6, 1});
    for (int frame = 0; frame < 2; ++frame) {
      maker.Point(10.0, 20.0, 30.0);
      for (int c = 1; c <= 6; ++c) maker.Value(32777);
    }
    const auto plates = ReadForcePlates(Put(maker.Make()));
    ASSERT_EQ(plates.size(), 1u) << format;
    EXPECT_EQ(plates[0].load_n, std::vector<double>(2, load_n)) << format;
  }
}

TEST_F(TracksC3d, ReadsSegmentsAfterPoints) {
  C3dMaker maker = OnePoint(1, 65535, 32 * 4);  // a block has 32 frames
  maker.Header(1, 1, 0);
  maker.Words("ROTATION:USED", {1}).Words("ROTATION:DATA_START", {8});
  maker.Texts("ROTATION:LABELS", {"pelvis_4X4"});
  for (int f = 0; f < 128; ++f) {
    Eigen::Matrix4d pose = Eigen::Matrix4d::Identity();
    pose(2, 3) = 900.0 + f;
    maker.Matrix(pose, 0.0);
  }
  EXPECT_EQ(Read(maker).frames.size(), 128u)
      << "points end where the segments begin";
  EXPECT_EQ(Read(maker).header.skeleton.joints(), Names{"nose"});
  const SegmentSequence segments = ReadSegments(folder_.path() / "walk.c3d");
  ASSERT_EQ(segments.frames.size(), 128u);
  EXPECT_EQ(segments.frames[127].world_from_segment[0]->translation().z(),
            1.027);
  EXPECT_TRUE(ReadSegments(Put(OnePoint(1, 9, 9).Make())).frames.empty());
}

// Theia3D's segments and a person's markers in the same recording.
TEST_F(TracksC3d, TheiaSegmentsAreAtTheMarkers) {
  KINEGRAPH_DATA_OR_SKIP(folder, "markers/qualisys_theia");
  const TrackSequence theia = ReadTracks(folder + "/dynamic_1_theia.c3d");
  const TrackSequence markers = ReadTracks(folder + "/dynamic_1_markers.c3d");
  ASSERT_EQ(theia.frames.size(), 662u);
  ASSERT_EQ(markers.frames.size(), 662u);
  EXPECT_EQ(theia.header.frame_rate_hz, 200.0);
  EXPECT_EQ(theia.header.skeleton.joints().size(), 20u);
  const auto at = [](const TrackSequence& tracks, size_t f, const char* joint) {
    const Names& joints = tracks.header.skeleton.joints();
    const auto found = std::find(joints.begin(), joints.end(), joint);
    EXPECT_NE(found, joints.end()) << joint;
    const auto& people = tracks.frames[f].people;
    if (found == joints.end() || people.empty()) return Joint3d();
    return people[0].joints[static_cast<size_t>(found - joints.begin())];
  };
  // Median distances of the origin from the middle of the joint's markers,
  // computed by an independent script (README of the data).
  for (const auto& [segment, out, in, median_mm] :
       {std::tuple{"l_larm", "LElbowOut", "LElbowIn", 23.7},
        {"r_larm", "RElbowOut", "RElbowIn", 21.0},
        {"l_hand", "LWristOut", "LWristIn", 10.2},
        {"r_hand", "RWristOut", "RWristIn", 14.9}}) {
    std::vector<double> distances_mm;
    for (size_t f = 0; f < 662; ++f) {
      const Joint3d a = at(markers, f, out);
      const Joint3d b = at(markers, f, in);
      const Joint3d origin = at(theia, f, segment);
      if (!a.present() || !b.present() || !origin.present()) continue;
      distances_mm.push_back(
          1000.0 *
          (origin.position_m - 0.5 * (a.position_m + b.position_m)).norm());
    }
    ASSERT_GT(distances_mm.size(), 600u);
    const auto middle = distances_mm.begin() +
                        static_cast<std::ptrdiff_t>(distances_mm.size() / 2);
    std::nth_element(distances_mm.begin(), middle, distances_mm.end());
    EXPECT_NEAR(*middle, median_mm, 0.051) << segment << ", given to 0.1 mm";
  }
}

// ---- Files written by kinegraph ----

TrackSequence NosesAt(const std::vector<Vector3d>& positions_m) {
  TrackSequence tracks;
  tracks.header.skeleton = Skeleton("one", {"nose"}, {});
  tracks.header.frame_rate_hz = 100.0;
  for (const Vector3d& position_m : positions_m) {
    TrackFrame& frame = tracks.frames.emplace_back();
    frame.frame = static_cast<int64_t>(tracks.frames.size()) - 1;
    frame.time = frame.frame * 10'000'000;
    PersonPose& person = frame.people.emplace_back();
    person.id = TrackId(4);
    person.joints = {{position_m, JointStatus::kObserved}};
  }
  return tracks;
}

TEST_F(TracksC3d, WritesMoreFramesThanAWordCanCount) {
  const std::string path = folder_.path() / "long.c3d";
  for (const size_t count : {size_t{65534}, size_t{65535}, size_t{65600}}) {
    testing::WriteAs(
        "c3d", path,
        NosesAt(std::vector<Vector3d>(count, Vector3d(0.5, 0.25, 1.0))),
        {{}, {{TrackId(4), "Anna"}}});
    std::string bytes = ReadTextFile(path);
    EXPECT_EQ(bytes.find("LONG_FRAMES") != std::string::npos, count >= 65535);
    // SUBJECTS:NAMES, and EVENT:SUBJECTS of the first and the last frame.
    int named = 0;
    for (size_t at = 0; (at = bytes.find("Anna", at)) != std::string::npos;
         ++at) {
      ++named;
    }
    EXPECT_EQ(named, 3);
    EXPECT_EQ(ReadTracks(path).frames.size(), count);
    // The count is found without TRIAL, and also without LONG_FRAMES (then from
    // the size of the file).
    for (const char* gone : {"TRIAL", "LONG_FRAMES"}) {
      const size_t at = bytes.find(gone);
      if (at == std::string::npos) continue;
      bytes[at] = 'X';
      Put(bytes);
      EXPECT_EQ(ReadTracks(folder_.path() / "walk.c3d").frames.size(), count)
          << gone;
    }
  }
}

TEST_F(TracksC3d, JointAtTheOriginIsNotMissing) {
  const std::string path = folder_.path() / "origin.c3d";
  testing::WriteAs("c3d", path,
                   NosesAt({Vector3d::Zero(), Vector3d(0.0, 0.0, 0.5)}));
  const TrackSequence tracks = ReadTracks(path);
  ASSERT_EQ(tracks.frames[0].people.size(), 1u);
  // At the smallest normal float, 1.2e-38 mm.
  EXPECT_LT(tracks.frames[0].people[0].joints[0].position_m.norm(), 1e-40);
}

}  // namespace
}  // namespace kinegraph
