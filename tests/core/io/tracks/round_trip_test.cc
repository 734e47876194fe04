// Tracks are written and read back: preserved data is bit-identical or, in
// formats with another unit or 32-bit floats, equal to rounding; lost data is
// reported.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "core/io/binary/npz_file.h"
#include "core/io/files/text_file.h"
#include "core/io/text/joint_names.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/tracks.h"
#include "tests/core/io/input_error.h"
#include "tests/core/io/tracks/recordings.h"
#include "tests/support/opensim_trc.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using testing::InputErrorOf;
using ::testing::IsEmpty;
using testing::RandomTracks;
using testing::TemporaryFolder;
using testing::WriteAs;

struct Case {
  std::string format;
  const Skeleton* skeleton;  // that a reader recognises
  bool keeps_status = false;
  bool keeps_empty_frames = true;
  // Relative error of positions; 0: the same bits.
  double tolerance = 0.0;
};

constexpr double kUnit = 4e-16;    // to cm and back: three roundings of 2^-53
constexpr double kFloat = 1.2e-7;  // rounding to 32 bits: 2^-24, doubled

class TrackRoundTrip : public ::testing::TestWithParam<Case> {};

void ExpectSamePerson(const PersonPose& a, const PersonPose& b,
                      const Case& format) {
  EXPECT_EQ(a.id, b.id);
  ASSERT_EQ(a.joints.size(), b.joints.size());
  for (size_t j = 0; j < a.joints.size(); ++j) {
    ASSERT_EQ(a.joints[j].present(), b.joints[j].present()) << j;
    if (format.keeps_status) {
      EXPECT_EQ(a.joints[j].status, b.joints[j].status);
    }
    if (!a.joints[j].present()) continue;
    for (int axis = 0; axis < 3; ++axis) {
      const double expected = a.joints[j].position_m[axis];
      EXPECT_NEAR(b.joints[j].position_m[axis], expected,
                  format.tolerance * std::abs(expected));
    }
    if (!format.keeps_status) continue;
    ASSERT_EQ(a.covariances[j].has_value(), b.covariances[j].has_value());
    if (a.covariances[j]) {
      EXPECT_EQ(*a.covariances[j], *b.covariances[j]);
    }
  }
  if (format.keeps_status) {
    EXPECT_EQ(a.inlier_views, b.inlier_views);
  }
}

TEST_P(TrackRoundTrip, ReadsBack) {
  const Case& format = GetParam();
  const TrackSequence tracks = RandomTracks(*format.skeleton);
  const TemporaryFolder folder;
  const std::string path = folder.path() / "result";
  const LostFields lost_fields = WriteAs(format.format, path, tracks);
  if (format.format == "trc") {
    EXPECT_TRUE(testing::OpenSimReads(path));
  }
  EXPECT_EQ(ListFolder(folder.path().string()).size(), 1u)
      << "files other than the result";
  for (const std::string& read : {std::string(), format.format}) {
    TrackReadOptions options;
    options.format = read;
    options.frame_rate_hz = 25.0;
    const TrackSequence again = ReadTracks(path, options);
    EXPECT_TRUE(again.header.skeleton == *format.skeleton);
    std::vector<const TrackFrame*> expected;
    for (const TrackFrame& frame : tracks.frames) {
      if (format.keeps_empty_frames || !frame.people.empty()) {
        expected.push_back(&frame);
      }
    }
    // actorsGT.mat (tum) has no frame numbers: the frames read from it begin at
    // 0, those of RandomTracks at 300.
    std::vector<const TrackFrame*> found;
    for (const TrackFrame& frame : again.frames) {
      if (frame.frame >= 300) found.push_back(&frame);
    }
    ASSERT_EQ(found.size(), expected.size());
    for (size_t f = 0; f < found.size(); ++f) {
      EXPECT_EQ(found[f]->frame, expected[f]->frame);
      EXPECT_EQ(found[f]->time, expected[f]->time);
      ASSERT_EQ(found[f]->people.size(), expected[f]->people.size());
      for (size_t p = 0; p < found[f]->people.size(); ++p) {
        ExpectSamePerson(expected[f]->people[p], found[f]->people[p], format);
      }
    }
  }
  const bool loses_status = std::any_of(
      lost_fields.begin(), lost_fields.end(), [](const std::string& loss) {
        return loss.find("inferred joints") != std::string::npos;
      });
  EXPECT_EQ(loses_status, !format.keeps_status) << "losses must be reported";
}

INSTANTIATE_TEST_SUITE_P(
    Formats, TrackRoundTrip,
    ::testing::Values(Case{"csv", &Coco17(), true, false},
                      Case{"npz", &Body25(), true}, Case{"trc", &Coco17()},
                      Case{"c3d", &Coco17(), false, true, kFloat},
                      Case{"longcw", &Coco17(), false, true, kUnit},
                      Case{"4da", &FourDA19()},
                      Case{"panoptic", &Panoptic19(), false, true, kUnit},
                      Case{"tum", &Tum14()}),
    [](const auto& format) { return format.param.format; });

// ---- Peculiarities of individual formats

TEST(TrackExport, TimesSince1970AreReadBack) {
  TrackSequence tracks = RandomTracks(Coco17());
  const TimeNs shift = FromSeconds(1'764'000'000.0);  // 24 November 2025
  for (TrackFrame& frame : tracks.frames) frame.time = frame.time + shift;
  for (const char* format : {"csv", "npz", "trc"}) {
    const TemporaryFolder folder;
    const std::string path = folder.path() / "result";
    WriteAs(format, path, tracks);
    const TrackSequence again = ReadTracks(path, {});
    const auto& expected = tracks.frames.back();
    ASSERT_FALSE(expected.people.empty());
    EXPECT_EQ(again.frames.back().frame, expected.frame) << format;
    // A double of 1.8e9 s has a resolution of 2.4e-7 s.
    EXPECT_NEAR(ToSeconds(again.frames.back().time - expected.time), 0.0, 3e-7)
        << format;
  }
}

// kinegraph's own files state the time 0 if times are unknown.
TEST(TracksKinegraph, TimesFollowARateGivenLater) {
  const TrackSequence timed = RandomTracks(Coco17());
  TrackSequence tracks = timed;
  tracks.header.frame_rate_hz = 0.0;
  for (TrackFrame& frame : tracks.frames) frame.time = 0;
  const TemporaryFolder folder;
  const std::string path = folder.path() / "tracks.jsonl";
  WriteAs("kinegraph", path, tracks);
  TrackReadOptions options;
  options.frame_rate_hz = 25.0;
  const TrackSequence again = ReadTracks(path, options);
  ASSERT_EQ(again.frames.size(), timed.frames.size());
  for (size_t f = 0; f < timed.frames.size(); ++f) {
    EXPECT_EQ(again.frames[f].time, timed.frames[f].time);
  }
  EXPECT_EQ(ReadTracks(path).frames.back().time, 0);
}

// In Pose2Sim's files Y is up; it becomes the world's z.
TEST(TracksTrc, Pose2SimFilesAreRead) {
  KINEGRAPH_DATA_OR_SKIP(peers, "pose2sim/peer_result");
  struct Peer {
    const char* file;
    int64_t id;
  };
  for (const Peer& peer :
       {Peer{"S00_P00_T01_BalancingTrial_0-100.trc", 0},
        Peer{"S00_P01_T02_Participants1-2_P2_0-100_filt_butterworth.trc", 2}}) {
    const TrackSequence own = ReadTracks(peers + "/" + peer.file);
    EXPECT_EQ(own.header.frame_rate_hz, 60.0);
    EXPECT_EQ(own.header.skeleton.joints().front(), "r_hip")
        << "renamed, although no built-in skeleton has these joints";
    ASSERT_EQ(own.frames.size(), 100u);
    EXPECT_EQ(own.frames[0].frame, 0) << "OrigDataStartFrame";
    // The nth row is at n / 60 s. One of the files has times of sixteen digits.
    EXPECT_EQ(own.frames[99].time, FromSeconds(100.0 / 60.0));
    const PersonPose& person = own.frames[50].people.at(0);
    EXPECT_EQ(person.id, TrackId(peer.id));
    const int head = own.header.skeleton.IndexOf("head_top");
    const int ankle = own.header.skeleton.IndexOf("r_ankle");
    EXPECT_GT(person.joints[static_cast<size_t>(head)].position_m.z(),
              person.joints[static_cast<size_t>(ankle)].position_m.z() + 1.0)
        << "z is up again";
  }
  // In the folder several names have the same person number, so people are
  // numbered in order.
  EXPECT_EQ(ReadTracks(peers).frames[0].people.size(), 6u);
}

constexpr const char* kTrcHeader =
    "PathFileType\t4\t(X/Y/Z)\tx.trc\n"
    "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\t"
    "OrigDataStartFrame\tOrigNumFrames\n"
    "100\t100\t2\t1\tmm\t100\t7\t2\n"
    "Frame#\tTime\tC7\t\t\n\t\tX1\tY1\tZ1\n";

TEST(TracksTrc, ReadsMillimetresOtherAxesAndMissingMarkers) {
  const TemporaryFolder folder;
  const std::string path = folder.Write(
      "walk.trc", std::string(kTrcHeader) +
                      "\n1\t0.0\t1000\t2000\t3000\r\n2\t0.01\tNaN\t\t\n");
  TrackReadOptions options;
  options.axes = AxisMap::Parse("x,-y,-z");
  const TrackSequence tracks = ReadTracks(path, options);
  EXPECT_EQ(tracks.header.frame_rate_hz, 100.0);
  ASSERT_EQ(tracks.frames.size(), 2u);
  EXPECT_EQ(tracks.frames[0].frame, 7);
  EXPECT_EQ(tracks.frames[0].people.at(0).joints.at(0).position_m,
            Eigen::Vector3d(1.0, -2.0, -3.0));
  EXPECT_TRUE(tracks.frames[1].people.empty());
  EXPECT_EQ(tracks.frames[1].time, 10'000'000);
}

// Normally the time of the first row decides. OrigDataStartFrame does if the
// times begin anew (at 0 or, in row 1, after one frame), are negative, or lie
// between frames. Laboratories count it from 1: 1 with the time 0 is frame 0.
TEST(TracksTrc, FirstFrameIsAtTheTimeOfTheFirstRowOrOrigDataStartFrame) {
  const TemporaryFolder folder;
  const auto first_frame = [&](const std::string& start,
                               const std::string& row) {
    std::string text = kTrcHeader;
    text.replace(text.find("100\t7\t2"), 7, "100\t" + start + "\t2");
    return ReadTracks(folder.Write("x.trc", text + "\n" + row +
                                                "\t1\t2\t3\n9\t9\t1\t2\t3\n"))
        .frames.at(0)
        .frame;
  };
  EXPECT_EQ(first_frame("0", "1\t0.00"), 0);
  EXPECT_EQ(first_frame("1", "1\t0.00"), 0);
  EXPECT_EQ(first_frame("1", "1\t0.01"), 1);  // as kinegraph writes frame 1
  EXPECT_EQ(first_frame("1", "101\t1.00"), 100);
  EXPECT_EQ(first_frame("1", "101\t1.01"), 101);
  EXPECT_EQ(first_frame("30", "1\t0.30"), 30);
  EXPECT_EQ(first_frame("30", "1\t0.00"), 30);
  EXPECT_EQ(first_frame("30", "30\t0.00"), 30);
  // Pose2Sim's rows and times count from 1.
  EXPECT_EQ(first_frame("0", "1\t0.01"), 0);
  EXPECT_EQ(first_frame("30", "1\t0.01"), 30);
  // Trimmed files: times count, whether rows or the first frame are renumbered.
  EXPECT_EQ(first_frame("1", "4\t0.03"), 3);
  EXPECT_EQ(first_frame("0", "1\t0.03"), 3);
  EXPECT_EQ(first_frame("1", "1\t0.03"), 3);
  EXPECT_EQ(first_frame("101", "1\t1.10"), 110);
  EXPECT_EQ(first_frame("0", "57\t12.34"), 1234);
  EXPECT_EQ(first_frame("0", "\t0.03"), 3);
  // Times that are rounded, lie between frames, or begin before 0.
  EXPECT_EQ(first_frame("1", "1\t0.0317"), 3);
  EXPECT_EQ(first_frame("1", "1\t0.035"), 1);
  EXPECT_EQ(first_frame("1", "1\t-0.5"), 1);
}

TEST(TracksTrc, RoundedTimesAt2997HertzGiveTheFirstFrame) {
  const TemporaryFolder folder;
  for (const int64_t frame : {2, 100, 1799}) {
    std::string text = kTrcHeader;
    text.replace(text.find("100\t100\t2"), 9, "29.97\t29.97\t1");
    text.replace(text.find("100\t7\t2"), 7, "29.97\t0\t1");
    const double time_s = static_cast<double>(frame) * 1001.0 / 30000.0;
    text += "1\t" + std::to_string(time_s).substr(0, 5) + "\t1\t2\t3\n";
    EXPECT_EQ(ReadTracks(folder.Write("x.trc", text)).frames.at(0).frame,
              frame);
  }
}

// Byte order marks and old Mac line ends are accepted; other separators are
// reported.
TEST(TracksTrc, AcceptsMarksAndLineEndsOfOtherSystemsNotSeparators) {
  const TemporaryFolder folder;
  const std::string text =
      std::string(kTrcHeader) + "1\t0.0\t1\t2\t3\n2\t0.01\t1\t2\t3\n";
  const auto replaced = [&](char from, const std::string& to) {
    std::string other;
    for (const char c : text) other += c == from ? to : std::string(1, c);
    return other;
  };
  for (const std::string& other :
       {"\xef\xbb\xbf" + text, replaced('\n', "\r\n"), replaced('\n', "\r"),
        "\xef\xbb\xbf" + replaced('\n', "\r"), replaced('\n', " \t\n")}) {
    const TrackSequence tracks = ReadTracks(folder.Write("x.trc", other));
    ASSERT_EQ(tracks.frames.size(), 2u) << other;
    EXPECT_EQ(tracks.header.skeleton.joints().at(0), "C7");
    EXPECT_EQ(tracks.frames[1].people.at(0).joints.at(0).position_m.x(), 0.003);
  }
  for (const char* separator : {",", " ", ";"}) {
    EXPECT_THAT(InputErrorOf([&] {
                  ReadTracks(folder.Write("x.trc", replaced('\t', separator)));
                }),
                HasSubstr("expected tabs between cells"));
  }
}

using Broken = std::vector<std::pair<std::string, std::string>>;

// Expects the error broken[i].second for a file of `header` and the rows
// broken[i].first.
void ExpectErrors(const std::string& name, const std::string& header,
                  const Broken& broken) {
  const TemporaryFolder folder;
  for (const auto& [rows, expected] : broken) {
    const std::string path = folder.Write(name, header + rows);
    EXPECT_THAT(InputErrorOf([&] { ReadTracks(path); }), HasSubstr(expected));
  }
}

TEST(TracksTrc, ErrorsNameFileAndLine) {
  ExpectErrors(
      "walk.trc", kTrcHeader,
      {{"1\t0.0\t1\t2\t3\n", "NumFrames is 2"},
       {"1\t0.0\t1\t2\n", "walk.trc: line 6: found 4 cells, expected 5"},
       {"1\t0.0\t1\t2\tx\n", "line 6: found the text 'x', expected a number"},
       {"1\t0,0\t1\t2\t3\n",
        "found the text '0,0', expected a number with a decimal point"},
       {"1\t0.0\t1\t2\t\n", "some coordinates"},
       {"1\t\t1\t2\t3\n", "Time"}});
}

// A table as saved by Excel with decimal commas.
TEST(TracksCsv, ReadsSemicolonsAndDecimalCommas) {
  const TemporaryFolder folder;
  const std::string head = "frame;time_s;id;joint;x_m;y_m;z_m;status\r\n";
  const std::string row = "3;0,12;1;l_hip;1,5;-2;3,25;observed\r\n";
  const std::string path =
      folder.Write("excel.csv", "\xef\xbb\xbf" + head + row);
  EXPECT_EQ(RecogniseTracks(LookAtTracks(path))->name, "csv");
  const TrackSequence tracks = ReadTracks(path);
  ASSERT_EQ(tracks.frames.size(), 1u);
  EXPECT_EQ(tracks.frames[0].time, 120'000'000);
  EXPECT_EQ(tracks.frames[0].people.at(0).joints.at(0).position_m,
            Eigen::Vector3d(1.5, -2, 3.25));
  EXPECT_THAT(
      InputErrorOf([&] {
        ReadTracks(folder.Write(
            "b.csv", head + "3;0,12;1;l_hip;1.234,5;-2;3;observed\n"));
      }),
      HasSubstr("b.csv: line 2: x_m: found the text '1.234,5', expected "
                "a number with a decimal point"));
}

TEST(TracksCsv, ReadsColumnsInAnyOrderAndQuotedNames) {
  const TemporaryFolder folder;
  const std::string path =
      folder.Write("own.csv",
                   "status,joint,frame,id,z_m,x_m,y_m,extra,time_s\n"
                   "observed,\"a,\"\"b\"\"\",5,1,3,1,2,?,0.5\n"
                   "missing,c,5,1,,,,?,0.5\n"
                   "inferred,c,4,1,6,4,5,?,\n");
  TrackReadOptions options;
  options.format = "csv";
  const TrackSequence tracks = ReadTracks(path, options);
  EXPECT_EQ(tracks.header.skeleton.joints(),
            (std::vector<std::string>{"a,\"b\"", "c"}));
  ASSERT_EQ(tracks.frames.size(), 2u);
  EXPECT_EQ(tracks.frames[0].frame, 4);
  EXPECT_EQ(tracks.frames[0].people.at(0).joints[1].position_m,
            Eigen::Vector3d(4, 5, 6));
  EXPECT_FALSE(tracks.frames[0].people.at(0).joints[0].present());
  EXPECT_EQ(tracks.frames[1].time, 500'000'000);
  EXPECT_EQ(tracks.frames[1].people.at(0).joints[0].position_m,
            Eigen::Vector3d(1, 2, 3));
}

TEST(TracksCsv, LabelsInAnySpellingAreRead) {
  const TemporaryFolder folder;
  const std::string path = folder.path() / "tracks.csv";
  for (const Skeleton& skeleton :
       {WithMarkerNames(Coco17(), MarkerNames::kPose2Sim),
        Skeleton("arm", {"head", "l_shoulder", "l_elbow", "l_wrist"}, {})}) {
    const TrackSequence tracks = RandomTracks(skeleton);
    WriteAs("csv", path, tracks);
    const TrackSequence again = ReadTracks(path);
    EXPECT_EQ(again.header.skeleton.joints(), OurJointNames(skeleton.joints()));
    const Pose3d& expected = tracks.frames.back().people.at(0).joints;
    const Pose3d& found = again.frames.back().people.at(0).joints;
    ASSERT_EQ(found.size(), expected.size());
    for (size_t j = 0; j < expected.size(); ++j) {
      ASSERT_EQ(found[j].status, expected[j].status);
      if (!expected[j].present()) continue;
      EXPECT_EQ(found[j].position_m, expected[j].position_m);
    }
  }
}

TEST(TracksCsv, ErrorsNameFileAndLine) {
  const std::string row = "1,0,0,a,1,2,3,observed\n";
  ExpectErrors(
      "own.csv", "frame,time_s,id,joint,x_m,y_m,z_m,status\n",
      {{"1,0,0,a,1,2,observed\n", "own.csv: line 2: found 7 cells, expected 8"},
       {"1,0,0,a,1,2,,observed\n", "z_m: found ''"},
       {"1,0,0,a,1,2,inf,observed\n", "z_m: found 'inf', expected a number"},
       {"1,0,0,a,1,2,3,seen\n", "status: found"},
       {"1.5,0,0,a,1,2,3,observed\n", "frame: found"},
       {"1,0,-1,a,1,2,3,observed\n", "id: found"},
       {row + row, "line 3: joint 'a' appears twice"},
       {row + "1,0,1,a,1,2,3,observed\n" + row, "person 0 appears twice"}});
}

TEST(TracksNpz, ReadsArraysWrittenByNumpy) {
  if (!testing::HasPython("numpy"))
    GTEST_SKIP() << "needs numpy of /usr/bin/python3";
  const TemporaryFolder folder;
  const std::string path = folder.path() / "numpy.npz";
  const auto write = [&](const std::string& function) {
    const std::string script = folder.Write(
        "write.py",
        "import numpy as np\np = np.arange(36.).reshape(3, 2, 2, 3)"
        "\np[1, 0] = np.nan\nnp." +
            function + "('" + path +
            "', positions=p, ids=np.array([4, 9]),"
            "frames=np.array([1, 2, 5], dtype=np.uint16), joints=['a', "
            "'\u00e9'])");
    return std::system(("/usr/bin/python3 " + script).c_str());
  };
  ASSERT_EQ(write("savez"), 0);
  const TrackSequence tracks = ReadTracks(path);
  EXPECT_EQ(tracks.header.skeleton.joints(),
            (std::vector<std::string>{"a", "\u00e9"}));
  ASSERT_EQ(tracks.frames.size(), 3u);
  EXPECT_EQ(tracks.frames[2].frame, 5);
  ASSERT_EQ(tracks.frames[1].people.size(), 1u) << "only NaN: absent";
  EXPECT_EQ(tracks.frames[1].people[0].id, TrackId(9));
  EXPECT_EQ(tracks.frames[1].people[0].joints[1].position_m,
            Eigen::Vector3d(21, 22, 23));
  ASSERT_EQ(write("savez_compressed"), 0);
  EXPECT_THAT(InputErrorOf([&] { ReadTracks(path); }),
              HasSubstr("is compressed, expected an archive of numpy.savez"));
}

TEST(TracksPanoptic, JointsAreMappedByName) {
  const TrackSequence tracks = RandomTracks(Coco17());
  const TemporaryFolder folder;
  EXPECT_THAT(WriteAs("panoptic", folder.path() / "scene", tracks),
              Contains(HasSubstr("17 of the input's 17 are kept")));
  const TrackSequence again = ReadTracks(folder.path() / "scene");
  const auto at = static_cast<size_t>(Panoptic19().IndexOf("l_wrist"));
  for (size_t f = 0; f < tracks.frames.size(); ++f) {
    for (size_t p = 0; p < tracks.frames[f].people.size(); ++p) {
      EXPECT_EQ(again.frames[f].people[p].joints[at].present(),
                tracks.frames[f].people[p].joints[9].present());
    }
  }
}

TEST(TrackExport, LongcwAndTumRefuseWhatTheyCannotExpress) {
  const TemporaryFolder folder;
  const std::string path = folder.path() / "result";
  const auto error = [](const std::string& format, const std::string& to,
                        const TrackSequence& tracks) {
    return InputErrorOf([&] { WriteAs(format, to, tracks); });
  };
  TrackSequence tracks = RandomTracks(Tum14());
  tracks.frames[3].time += 30'000'000;
  EXPECT_THAT(error("longcw", path, tracks), HasSubstr("frame 303"));
  tracks.header.frame_rate_hz = 0.0;
  EXPECT_THAT(error("longcw", path, tracks), HasSubstr("--frame_rate"));
  tracks.frames[0].people[0].id = TrackId(123456);
  EXPECT_THAT(error("tum", path, tracks), HasSubstr("largest id is 123456"));
  EXPECT_THAT(error("tum", "/nowhere/x.mat", RandomTracks(Tum14())),
              HasSubstr("/nowhere/x.mat"));
  EXPECT_TRUE(ListFolder(folder.path().string()).empty());
}

// ---- Writers

TEST(TrackExport, CsvQuotesJointNames) {
  TrackSequence tracks;
  tracks.header.skeleton = Skeleton("odd", {"a,b", "c\"d"}, {});
  TrackFrame frame;
  frame.people.resize(1);
  frame.people[0].id = TrackId(1);
  frame.people[0].joints.resize(2);
  tracks.frames = {frame};
  const TemporaryFolder folder;
  const std::string path = folder.path() / "tracks.csv";
  WriteAs("csv", path, tracks);
  EXPECT_EQ(ReadTextFile(path),
            "frame,time_s,id,joint,x_m,y_m,z_m,status\n"
            "0,,1,\"a,b\",,,,missing\n0,,1,\"c\"\"d\",,,,missing\n");
}

TEST(TrackExport, CsvNotesThatATableWithoutPeopleCannotBeReadBack) {
  TrackSequence tracks = RandomTracks(Coco17());
  for (TrackFrame& frame : tracks.frames) frame.people.clear();
  const TemporaryFolder folder;
  const std::string path = folder.path() / "tracks.csv";
  EXPECT_THAT(WriteAs("csv", path, tracks),
              Contains(HasSubstr("cannot be read back")));
}

TEST(TrackExport, TrcAxesKeepLeftAndRight) {
  const Eigen::Vector3d world(1.0, 2.0, 3.0);
  EXPECT_EQ(AxisMap().Apply(world), Eigen::Vector3d(2, 3, 1));
  EXPECT_EQ(AxisMap::Parse("y,z,x").Apply(world), Eigen::Vector3d(2, 3, 1));
  EXPECT_EQ(AxisMap::Parse("x,-y,-z").Apply(world), Eigen::Vector3d(1, -2, -3));
  for (const char* text : {"", "x", "x,y", "x,y,z,x", "x,y,y", "x y z", "a,b,c",
                           "x,z,y", "-x,y,z", "--x,y,z", "x,y,z,", ",x,y"}) {
    EXPECT_THAT(InputErrorOf([&] { AxisMap::Parse(text); }),
                HasSubstr("--axes"))
        << text;
  }
}

TEST(TrackExport, TrcRefusesWhatItCannotExpress) {
  const TemporaryFolder folder;
  const auto error_of = [&](const TrackSequence& tracks) {
    return InputErrorOf([&] { WriteAs("trc", folder.path() / "trc", tracks); });
  };
  TrackSequence tracks = RandomTracks(Coco17());
  tracks.header.frame_rate_hz = 0.0;
  EXPECT_THAT(error_of(tracks), HasSubstr("frame rate"));
  tracks = RandomTracks(Coco17());
  tracks.frames.back().frame = int64_t{1} << 40;
  EXPECT_THAT(error_of(tracks), HasSubstr("span"));
  tracks = RandomTracks(Coco17());
  for (TrackFrame& frame : tracks.frames) frame.people.clear();
  EXPECT_THAT(error_of(tracks), HasSubstr("no people"));
  EXPECT_THAT(ListFolder(folder.path().string()), IsEmpty());
}

TEST(NpzFile, CrcMatchesCatalogueValue) {
  // The check value of the catalogue of CRC algorithms (CRC-32/ISO-HDLC).
  EXPECT_EQ(Crc32("123456789"), 0xCBF43926u);
  EXPECT_EQ(Crc32(""), 0u);
}

// Expects a Python script to succeed; if an assertion fails, shows its message.
void ExpectPython(const TemporaryFolder& folder, const std::string& script) {
  const std::string path = folder.Write("check.py", script);
  const std::string errors = folder.path() / "errors.txt";
  EXPECT_EQ(std::system(("/usr/bin/python3 " + path + " 2> " + errors).c_str()),
            0)
      << ReadTextFile(errors);
}

TEST(TrackExport, NumpyReadsTheArrays) {
  if (!testing::HasPython("numpy"))
    GTEST_SKIP() << "needs numpy of /usr/bin/python3";
  TrackSequence tracks = RandomTracks(Coco17());
  tracks.frames.erase(tracks.frames.begin() + 3);  // a gap in the numbers
  const TemporaryFolder folder;
  const std::string npz = folder.path() / "tracks.npz";
  const std::string csv = folder.path() / "tracks.csv";
  WriteAs("npz", npz, tracks);
  // The CSV table contains the same bits and is the reference.
  WriteAs("csv", csv, tracks);
  ExpectPython(folder, R"(
import csv, zipfile, numpy as np
npz, table = ')" + npz + "', '" +
                           csv + R"('
assert zipfile.ZipFile(npz).testzip() is None
a = np.load(npz, allow_pickle=False)
assert sorted(a.files) == ['bones', 'covariance', 'frame_rate', 'frames', 'ids',
    'joints', 'positions', 'skeleton', 'status', 'times', 'views'], a.files
assert a['positions'].shape == (9, 3, 17, 3), a['positions'].shape
assert a['positions'].dtype == np.float64 and a['status'].dtype == np.int8
assert a['covariance'].shape == (9, 3, 17, 3, 3)
assert a['ids'].tolist() == [0, 2, 5]
assert a['frames'].tolist() == [300, 301, 302, *range(304, 310)]
assert a['frame_rate'] == 25.0 and str(a['skeleton']) == 'coco17'
assert a['bones'].shape[1] == 2 and a['bones'].max() < 17
joints = a['joints'].tolist()
assert joints[0] == 'nose' and len(joints) == 17
names = {'missing': 0, 'inferred': 1, 'observed': 2}
seen = np.full((9, 3, 17), False)
upper = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)]
for row in csv.DictReader(open(table)):
    f = a['frames'].tolist().index(int(row['frame']))
    p = a['ids'].tolist().index(int(row['id']))
    j = joints.index(row['joint'])
    seen[f, p, j] = True
    assert a['times'][f] == float(row['time_s'])
    assert a['status'][f, p, j] == names[row['status']]
    assert a['views'][f, p, j] == int(row['views'])
    for axis, key in enumerate(['x_m', 'y_m', 'z_m']):
        value = a['positions'][f, p, j, axis]
        assert np.isnan(value) if row[key] == '' else value == float(row[key])
    for (r, c), key in zip(upper, ['xx', 'xy', 'xz', 'yy', 'yz', 'zz']):
        text = row['cov_' + key + '_m2']
        for value in (a['covariance'][f, p, j, r, c], a['covariance'][f, p, j, c, r]):
            assert np.isnan(value) if text == '' else value == float(text)
assert seen.sum() == 17 * 21
assert (a['status'][~seen] == -1).all() and (a['views'][~seen] == -1).all()
assert np.isnan(a['positions'][~seen]).all()
)");
}

TEST(TrackExport, NumpyReadsOddNamesAndNoPeople) {
  if (!testing::HasPython("numpy"))
    GTEST_SKIP() << "needs numpy of /usr/bin/python3";
  TrackSequence tracks;
  tracks.header.skeleton = Skeleton(
      "k\xC3\xB6rper", {"\xE8\x86\x9D", "\xF0\x9F\x99\x82 b", "\xFF"}, {});
  tracks.frames.resize(2);
  tracks.frames[1].frame = 1;
  const TemporaryFolder folder;
  const std::string npz = folder.path() / "tracks.npz";
  WriteAs("npz", npz, tracks);
  ExpectPython(folder, R"(
import numpy as np
a = np.load(')" + npz + R"(', allow_pickle=False)
assert a['positions'].shape == (2, 0, 3, 3)
assert a['bones'].shape == (0, 2)
assert np.isnan(a['frame_rate']) and np.isnan(a['times']).all()
assert a['joints'].tolist() == ['\u819d', '\U0001F642 b', '\ufffd']
assert str(a['skeleton']) == 'k\u00f6rper'
assert 'covariance' not in a.files and 'views' not in a.files
)");
}

}  // namespace
}  // namespace kinegraph
