// Reads real data, whose counts are compared with those in the data's READMEs,
// and small files with known content.
#include "core/io/detections/source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>  // mkfifo

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <thread>

#include "core/base/error.h"
#include "core/io/detections/formats.h"
#include "core/io/detections/writer.h"
#include "tests/core/io/detections/detection_files.h"

namespace kinegraph {
namespace {

using ::testing::ElementsAre;
using testing::ExpectSameDetections;
using ::testing::HasSubstr;
using testing::JointOf;
using testing::RecordingIn;
using testing::TemporaryFolder;

// Calls `visit` with each person and the number of the view.
template <typename Visit>
void ForEachPerson(const DetectionSequence& sequence, const Visit& visit) {
  for (const DetectionFrame& frame : sequence.frames) {
    ASSERT_EQ(frame.views.size(), sequence.header.view_names.size());
    for (size_t v = 0; v < frame.views.size(); ++v) {
      for (const Detection& person : frame.views[v].detections) {
        visit(person, v);
      }
    }
  }
}

struct Counts {
  int people = 0;
  int missing_joints = 0;
  std::vector<int> people_of_view;
};

Counts Count(const DetectionSequence& sequence) {
  Counts counts;
  counts.people_of_view.resize(sequence.header.view_names.size());
  ForEachPerson(sequence, [&](const Detection& person, size_t v) {
    ++counts.people;
    ++counts.people_of_view[v];
    counts.missing_joints +=
        sequence.header.skeleton.joint_count() - CountFound(person);
  });
  return counts;
}

int CountMissing(const DetectionSequence& sequence, const std::string& joint) {
  const int index = sequence.header.skeleton.IndexOf(joint);
  int missing = 0;
  ForEachPerson(sequence, [&](const Detection& person, size_t) {
    missing += person.joints[index].found ? 0 : 1;
  });
  return missing;
}

// Expects bit-identical detections, including times.
void ExpectSame(const DetectionSequence& a, const DetectionSequence& b) {
  EXPECT_TRUE(a.header.skeleton == b.header.skeleton);
  EXPECT_EQ(a.header.frame_rate_hz, b.header.frame_rate_hz);
  ExpectSameDetections(a, b);
  for (size_t f = 0; f < std::min(a.frames.size(), b.frames.size()); ++f) {
    EXPECT_EQ(a.frames[f].time, b.frames[f].time);
    for (size_t v = 0; v < a.frames[f].views.size(); ++v) {
      EXPECT_EQ(a.frames[f].views[v].capture_time,
                b.frames[f].views[v].capture_time);
    }
  }
}

DetectionReadOptions OptionsWith(const std::string& skeleton_name,
                                 int64_t first_frame = 0) {
  DetectionReadOptions options;
  options.skeleton_name = skeleton_name;
  options.first_frame = first_frame;
  return options;
}

// "coco17, 301 frames at 0 Hz; cam0 831, cam1 755; 54 joints missing".
std::string Summary(const DetectionSequence& sequence) {
  const Counts counts = Count(sequence);
  std::ostringstream text;
  text << sequence.header.skeleton.name() << ", " << sequence.frames.size()
       << " frames at " << sequence.header.frame_rate_hz << " Hz";
  for (size_t v = 0; v < counts.people_of_view.size(); ++v) {
    text << (v == 0 ? "; " : ", ") << sequence.header.view_names[v] << " "
         << counts.people_of_view[v];
  }
  text << "; " << counts.missing_joints << " joints missing";
  return text.str();
}

// Counts from the READMEs of the data and from independent scripts. Frames that
// are missing in all views do not count.
TEST(ReadDetections, RealRecordingsHaveKnownCounts) {
  const auto expect = [](const char* path, const char* summary,
                         const DetectionReadOptions& options = {}) {
    KINEGRAPH_DATA_OR_SKIP(recording, path);
    EXPECT_EQ(Summary(ReadDetections(recording, options)), summary);
  };
  expect("pose2sim/single/pose",
         "body25b, 100 frames at 0 Hz; cam01_json 201, cam02_json 200, "
         "cam03_json 100, cam04_json 100; 815 joints missing",
         OptionsWith("body25b"));
  expect("shelf/reference/filled_coco17",
         "coco17, 301 frames at 0 Hz; cam0 831, cam1 755, cam2 879, cam3 "
         "778, cam4 777; 12844 joints missing");
  expect("campus/detections_modelled/typical",
         "coco17, 392 frames at 0 Hz; cam0 719, cam1 638, cam2 636; 8273 "
         "joints missing");
  expect("campus/annotation_2d.json",
         "tum14, 2000 frames at 25 Hz; Camera0 2175, Camera1 2175, Camera2 "
         "2175; 0 joints missing");
}

TEST(ReadDetections, ShelfOpenPoseHasKnownCounts) {
  KINEGRAPH_DATA_OR_SKIP(path, "shelf/detections/openpose");
  EXPECT_EQ(OpenDetections(path)->frame_count(), 301);
  const DetectionSequence sequence = ReadDetections(path);
  EXPECT_TRUE(sequence.header.skeleton == Body25());
  ASSERT_EQ(sequence.frames.size(), 301u);
  EXPECT_EQ(sequence.frames.front().frame, 300);
  EXPECT_EQ(sequence.frames.back().frame, 600);
  EXPECT_EQ(Count(sequence).people, 4507);
  // Counted by an independent script over the same files.
  EXPECT_EQ(Count(sequence).missing_joints, 27178);
  EXPECT_EQ(CountMissing(sequence, "r_wrist"), 1640);
  EXPECT_EQ(CountMissing(sequence, "l_wrist"), 1290);
  size_t fewest = 99;
  size_t most = 0;
  for (const DetectionFrame& frame : sequence.frames) {
    for (const ViewDetections& view : frame.views) {
      fewest = std::min(fewest, view.detections.size());
      most = std::max(most, view.detections.size());
    }
  }
  EXPECT_EQ(fewest, 1u);  // in 24 images
  EXPECT_EQ(most, 7u);    // in one image
}

TEST(ReadDetections, TimesFollowTheFrameRate) {
  KINEGRAPH_DATA_OR_SKIP(path, "shelf/detections/openpose");
  DetectionReadOptions options;
  options.frame_rate_hz = 25.0;
  const auto source = OpenDetections(path, options);
  DetectionFrame frame;
  ASSERT_TRUE(source->Next(&frame));
  EXPECT_EQ(frame.time, 12'000'000'000);
  EXPECT_EQ(frame.views[4].capture_time, 12'000'000'000);
  ASSERT_TRUE(source->Next(&frame));
  EXPECT_EQ(frame.time, 12'040'000'000);
}

TEST(ReadDetections, Body25BIsRecognisedUnlessBody25IsConfigured) {
  KINEGRAPH_DATA_OR_SKIP(path, "pose2sim/single/pose");
  EXPECT_TRUE(OpenDetections(path)->header().skeleton == Body25B());
  EXPECT_TRUE(OpenDetections(path, OptionsWith("body25"))->header().skeleton ==
              Body25());
}

TEST(ReadDetections, IndicesCountPeopleWithoutKeypoints) {
  KINEGRAPH_DATA_OR_SKIP(path, "pose2sim/multi/pose");
  const DetectionSequence sequence = ReadDetections(path);
  EXPECT_TRUE(sequence.header.skeleton == Body25B());
  EXPECT_THAT(Count(sequence).people_of_view, ElementsAre(299, 300, 200, 200));
  const auto& detections = sequence.frames[1].views[0].detections;
  std::vector<int> indices;
  for (const Detection& detection : detections) {
    indices.push_back(detection.index_in_file);
  }
  // cam01.0001.json holds three people, one of them empty.
  EXPECT_EQ(detections.size(), 2u);
  EXPECT_TRUE(std::is_sorted(indices.begin(), indices.end()));
  EXPECT_NE(indices, (std::vector<int>{0, 1}));
}

TEST(ReadDetections, ZeroConfidencesArePositionsOnRequest) {
  KINEGRAPH_DATA_OR_SKIP(path, "shelf/reference/filled_coco17");
  DetectionReadOptions options;
  options.zero_confidence = ZeroConfidence::kPosition;
  const DetectionSequence sequence = ReadDetections(path, options);
  EXPECT_EQ(Count(sequence).missing_joints, 0);
  for (const DetectionFrame& frame : sequence.frames) {
    const bool empty = frame.views[3].detections.empty();
    EXPECT_EQ(empty, frame.frame >= 411 && frame.frame <= 413) << frame.frame;
  }
  // The first person's right eye was filled with the position of the nose.
  const Keypoint& filled = JointOf(sequence, 0, 0, 0, 2);
  EXPECT_EQ(filled.confidence, 0.0);
  EXPECT_EQ(filled.px, Eigen::Vector2d(658.4368, 162.1114));
}

TEST(ReadDetections, LongcwAnnotationHasTimes) {
  KINEGRAPH_DATA_OR_SKIP(path, "campus/annotation_2d.json");
  const DetectionSequence sequence = ReadDetections(path);
  EXPECT_EQ(sequence.frames.back().frame, 1999);
  EXPECT_EQ(sequence.frames.back().time, 79'960'000'000);
  const auto first = std::find_if(
      sequence.frames.begin(), sequence.frames.end(),
      [](const auto& frame) { return !frame.views[0].detections.empty(); });
  ASSERT_NE(first, sequence.frames.end());
  EXPECT_EQ(first->views[0].detections[0].joints[0].px,
            Eigen::Vector2d(153.0, 204.0));
}

TEST(ReadDetections, LongcwTimesDoNotDependOnTheOrderOfImages) {
  const std::string a =
      R"("a/1.jpg": {"camera": "a", "timestamp": 1.0, "poses": []})";
  const std::string b =
      R"("b/1.jpg": {"camera": "b", "timestamp": 1.012, "poses": []})";
  DetectionReadOptions options;
  options.format = "longcw";
  const auto recording = [&](const std::string& images) {
    return RecordingIn(
        "annotation_2d.json",
        R"({"image_wh": [640, 480], "frames": {)" + images + "}}", options);
  };
  const DetectionSequence read = recording(a + ", " + b);
  ExpectSame(read, recording(b + ", " + a));
  ASSERT_EQ(read.frames.size(), 1u);
  EXPECT_EQ(read.frames[0].time, 1'000'000'000);
  EXPECT_EQ(read.frames[0].views[1].capture_time, 1'012'000'000);
}

// Two views whose clocks differ, -0.0, tiny and huge numbers, a missing joint.
DetectionSequence OddSequence() {
  DetectionSequence sequence;
  sequence.header.skeleton = Skeleton("pair", {"a \"b\"", "c"}, {{0, 1}});
  sequence.header.view_names = {"left\n", "right"};
  for (const int64_t number : {0, 7}) {
    DetectionFrame frame;
    frame.frame = number;
    frame.time = number * 1'000'000'007;
    frame.views.resize(2);
    frame.views[0].capture_time = frame.time;
    frame.views[1].capture_time = frame.time - 3;
    Detection detection;
    detection.joints.resize(2);
    detection.joints[0] = {{-0.0, 1e-310}, 5.5, true};
    frame.views[1].detections.push_back(detection);
    detection.joints[0] = {{-1e300, 0.1 + 0.2}, 1e-5, true};
    detection.index_in_file = 1;
    frame.views[1].detections.push_back(detection);
    sequence.frames.push_back(frame);
  }
  return sequence;
}

TEST(DetectionWriter, KeepsEveryBit) {
  const TemporaryFolder folder;
  const std::string path = folder.path() / "odd.jsonl";
  const DetectionSequence sequence = OddSequence();
  WriteDetections(path, sequence);
  const DetectionSequence read = ReadDetections(path);
  ExpectSame(sequence, read);
  EXPECT_EQ(OpenDetections(path)->frame_count(), 2);
  EXPECT_TRUE(
      std::signbit(read.frames[0].views[1].detections[0].joints[0].px.x()));
}

// Without a frame rate, times that are all 0 are unknown.
TEST(DetectionWriter, KeepsTheTimeOfAFirstFrameAtZero) {
  const TemporaryFolder folder;
  const std::string path = folder.path() / "times.jsonl";
  DetectionReadOptions options;
  options.frame_rate_hz = 25.0;
  for (const bool has_times : {true, false}) {
    DetectionSequence sequence = OddSequence();
    for (size_t f = 0; f < 2; ++f) {
      DetectionFrame& frame = sequence.frames[f];
      frame.frame = 300 + static_cast<int64_t>(f);
      frame.time = has_times ? static_cast<TimeNs>(f) * 40'000'000 : 0;
      for (auto& view : frame.views) view.capture_time = frame.time;
    }
    WriteDetections(path, sequence);
    const DetectionSequence read = ReadDetections(path, options);
    ASSERT_EQ(read.frames.size(), 2u);
    const TimeNs first = has_times ? 0 : 12'000'000'000;
    EXPECT_EQ(read.frames[0].time, first);
    EXPECT_EQ(read.frames[1].time, first + 40'000'000);
  }
}

TEST(DetectionWriter, LeavesNothingWithoutCommit) {
  const TemporaryFolder folder;
  const DetectionSequence sequence = OddSequence();
  {
    DetectionWriter writer(folder.path() / "odd.jsonl", sequence.header);
    writer.Write(sequence.frames[0]);
    EXPECT_THROW(writer.Write(sequence.frames[0]), std::logic_error);
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(DetectionWriter, RefusesNumbersThatAreNotFinite) {
  const TemporaryFolder folder;
  DetectionSequence sequence = OddSequence();
  sequence.frames[0].views[1].detections[0].joints[0].px.x() = NAN;
  EXPECT_THROW(WriteDetections(folder.path() / "nan.jsonl", sequence),
               std::logic_error);
}

TEST(ReadDetections, OpenPoseLayoutsFollowFromJointCount) {
  const auto person = [](int numbers) {
    std::string text = "{\"people\": [{\"pose_keypoints_2d\": [0";
    for (int n = 1; n < numbers; ++n) text += ", " + std::to_string(n);
    return text + "]}]}";
  };
  const TemporaryFolder folder;
  folder.Write("coco/c1/x_000000000007_keypoints.json", person(54));
  folder.Write("body/c1/x_7_keypoints.json", person(75));
  folder.Write("flat/x_7_keypoints.json", person(51));
  folder.Write("whole/c1/7.json", person(3 * 133));
  const auto skeleton = [&](const char* name) {
    return OpenDetections(folder.path() / name)->header().skeleton;
  };
  EXPECT_TRUE(skeleton("coco") == Coco18());
  EXPECT_TRUE(skeleton("body") == Body25());
  EXPECT_TRUE(skeleton("flat") == Coco17());
  EXPECT_THAT(OpenDetections(folder.path() / "flat")->header().view_names,
              ElementsAre("flat"));
  EXPECT_TRUE(skeleton("whole") == WholeBody133());
  std::vector<std::string> joints;
  for (int j = 0; j < 133; ++j) joints.push_back("j" + std::to_string(j));
  DetectionReadOptions options;
  options.skeleton = Skeleton("mine", joints, {});
  const auto sequence = ReadDetections(folder.path() / "whole", options);
  ASSERT_EQ(sequence.frames.size(), 1u);
  EXPECT_EQ(sequence.frames[0].frame, 7);
  EXPECT_EQ(sequence.frames[0].views[0].detections[0].joints[132].px,
            Eigen::Vector2d(396.0, 397.0));
}

TEST(ReadDetections, OpenPoseViewsMayLackFrames) {
  const std::string nobody = "{\"people\": []}";
  const TemporaryFolder folder;
  folder.Write("cam2/a_3_keypoints.json", nobody);
  folder.Write("cam10/a_1_keypoints.json", nobody);
  folder.Write("cam10/a_3_keypoints.json", nobody);
  const DetectionSequence sequence = ReadDetections(folder.path());
  EXPECT_THAT(sequence.header.view_names, ElementsAre("cam2", "cam10"));
  ASSERT_EQ(sequence.frames.size(), 2u);
  EXPECT_EQ(sequence.frames[0].frame, 1);
  EXPECT_EQ(sequence.frames[1].frame, 3);
}

TEST(ReadDetections, KinegraphFormatIsReadFromAPipe) {
  const TemporaryFolder folder;
  const std::string ours = folder.path() / "ours.jsonl";
  const std::string pipe = folder.path() / "pipe";
  WriteDetections(ours, OddSequence());
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  std::thread writer([&] {
    std::ofstream(pipe, std::ios::binary)
        << std::ifstream(ours, std::ios::binary).rdbuf();
  });
  ExpectSame(OddSequence(), ReadDetections(pipe));
  writer.join();
}

// ---- Views with their own frame rates ----

// A recording with frames 0 .. count_a - 1 of view a and 0 .. count_b - 1 of
// view b, one person each; index_in_file is the number of the frame.
DetectionSequence Counting(int64_t count_a, int64_t count_b,
                           double rate_hz = 25.0) {
  DetectionSequence sequence;
  sequence.header = {Coco17(), {"a", "b"}, rate_hz};
  for (int64_t n = 0; n < std::max(count_a, count_b); ++n) {
    DetectionFrame& frame = sequence.frames.emplace_back();
    frame.frame = n;
    frame.time = FrameClock(rate_hz).TimeOf(n);
    for (const int64_t count : {count_a, count_b}) {
      ViewDetections& view = frame.views.emplace_back();
      view.capture_time = frame.time;
      if (n >= count) continue;
      view.detections.resize(1);
      view.detections[0].index_in_file = static_cast<int>(n);
      view.detections[0].joints.resize(sequence.header.skeleton.joint_count());
    }
  }
  return sequence;
}

DetectionReadOptions Rates(const std::map<std::string, double>& rates_hz) {
  DetectionReadOptions options;
  options.view_frame_rate_hz = rates_hz;
  return options;
}

std::vector<DetectionFrame> Read(const DetectionSequence& sequence,
                                 const DetectionReadOptions& options) {
  const auto source = OpenRated(
      [&] { return std::make_unique<testing::SequenceSource>(sequence); },
      options);
  std::vector<DetectionFrame> frames;
  DetectionFrame frame;
  while (source->Next(&frame)) frames.push_back(frame);
  return frames;
}

std::vector<int64_t> NumbersOf(const DetectionSequence& sequence,
                               const DetectionReadOptions& options) {
  std::vector<int64_t> numbers;
  for (const DetectionFrame& frame : Read(sequence, options)) {
    numbers.push_back(frame.frame);
  }
  return numbers;
}

// A file in kinegraph's format with two views at 25 Hz, one joint and these
// frames.
std::string OwnFile(const std::string& frames) {
  return R"({"kinegraph_detections": 1, "skeleton": {"name": "s", )"
         R"("joints": ["a"], "bones": []}, "frame_rate": 25, )"
         R"("views": ["a", "b"]})"
         "\n" +
         frames;
}

TEST(RatedSource, ViewAtTwiceTheRateGivesEverySecondFrame) {
  const std::vector<DetectionFrame> frames =
      Read(Counting(10, 20), Rates({{"b", 50.0}}));
  ASSERT_EQ(frames.size(), 10u);
  for (int k = 0; k < 10; ++k) {
    ASSERT_EQ(frames[k].views[1].detections.size(), 1u);
    EXPECT_EQ(frames[k].views[1].detections[0].index_in_file, 2 * k);
    EXPECT_EQ(frames[k].views[1].capture_time, frames[k].time);
  }
}

TEST(RatedSource, LimitsApplyToViewsWithOtherRates) {
  const std::string text =
      OwnFile(R"({"frame": 0, "views": {"a": [{"joints": [[1, 2, 1]]}], )"
              R"("b": [{"joints": [[1, 2, 1]]}]}})");
  DetectionReadOptions options = Rates({{"a", 25.0}});
  options.frame_rate_hz = 25.0;
  EXPECT_EQ(RecordingIn("d.jsonl", text, options).frames.size(), 1u);
  options.max_per_frame = 1;
  EXPECT_THROW(RecordingIn("d.jsonl", text, options), InputError);
}

// Bad frames are rejected by the reader or by a limit on its frames.
TEST(DetectionSource, LastBadFrameIsTheLatest) {
  DetectionReadOptions options;
  options.skip_bad_frames = true;
  options.max_per_view = 1;
  const auto bad_frames_of = [&](const std::string& frames) {
    const TemporaryFolder folder;
    const auto source =
        OpenDetections(folder.Write("d.jsonl", OwnFile(frames)), options);
    DetectionFrame frame;
    while (source->Next(&frame)) {
    }
    return source->bad_frames();
  };
  const std::string unreadable = "{\"frame\": 1, \"vi\n";
  const std::string crowded =
      R"({"frame": 2, "views": {"a": [{"joints": [[100, 200, 1]]}, )"
      R"({"joints": [[300, 200, 1]]}], "b": []}})"
      "\n";
  EXPECT_EQ(bad_frames_of("").last, "");
  BadFrames bad = bad_frames_of(unreadable + crowded);
  EXPECT_EQ(bad.count, 2);
  EXPECT_THAT(bad.last, HasSubstr("frame 2"));
  bad = bad_frames_of(unreadable + crowded + unreadable);
  EXPECT_EQ(bad.count, 3);
  EXPECT_THAT(bad.last, HasSubstr("line 4"));
}

TEST(RatedSource, SlowViewHasNoDetectionsInSomeFrames) {
  // The view has 10 Hz and the recording 25 Hz, so that frames of the view
  // are 2.5 frames of the recording apart.
  const std::vector<DetectionFrame> frames =
      Read(Counting(10, 4), Rates({{"b", 10.0}}));
  ASSERT_EQ(frames.size(), 10u);
  std::vector<int> found;
  for (const DetectionFrame& frame : frames) {
    const ViewDetections& view = frame.views[1];
    if (view.detections.empty()) continue;
    found.push_back(view.detections[0].index_in_file);
    EXPECT_EQ(view.capture_time,
              FrameClock(10.0).TimeOf(view.detections[0].index_in_file));
    // At most half a frame of the recording.
    EXPECT_LE(std::abs(view.capture_time - frame.time), FromSeconds(0.02));
  }
  EXPECT_EQ(found, (std::vector<int>{0, 1, 2, 3}));
}

// In a recording at 100 Hz, a view at 50 Hz has detections in every second
// frame and a view at 25 Hz in every fourth, up to the last frame of both; by
// the frame numbers in the files the recording would end earlier.
TEST(RatedSource, BaseRateAboveAllViewsLosesNoFrame) {
  const std::vector<DetectionFrame> frames =
      Read(Counting(20, 10, 100.0), Rates({{"a", 50.0}, {"b", 25.0}}));
  std::map<int64_t, std::vector<size_t>> seen;  // by frame
  for (const DetectionFrame& frame : frames) {
    EXPECT_EQ(frame.time, FrameClock(100.0).TimeOf(frame.frame));
    seen[frame.frame] = {frame.views[0].detections.size(),
                         frame.views[1].detections.size()};
  }
  for (int64_t k = 0; k < 20; ++k) {
    const std::vector<size_t> expected = {1, k % 2 == 0 ? size_t{1} : 0};
    EXPECT_EQ(seen[2 * k], expected) << k;
  }
}

// Frames without detections are returned between the first and the last
// detection.
TEST(RatedSource, KeepsFramesWithoutDetections) {
  DetectionSequence sequence = Counting(8, 8);
  for (size_t f = 2; f < 5; ++f) {
    for (auto& view : sequence.frames[f].views) view.detections.clear();
  }
  EXPECT_EQ(NumbersOf(sequence, Rates({{"b", 50.0}})),
            (std::vector<int64_t>{0, 1, 2, 3, 4, 5, 6, 7}));
}

// Numbers that occur only in files with another rate are not frames of the
// recording.
TEST(RatedSource, NumbersOfOtherRatesAreNotFrames) {
  // The recording at 25 Hz begins at frame 4. Files of b count at 50 Hz: frame
  // 8 of b is frame 4 of the recording.
  DetectionSequence sequence = Counting(12, 12);
  for (size_t f = 0; f < 8; ++f) {
    if (f < 4) sequence.frames[f].views[0].detections.clear();
    sequence.frames[f].views[1].detections.clear();
  }
  EXPECT_EQ(NumbersOf(sequence, Rates({{"b", 50.0}})),
            (std::vector<int64_t>{4, 5, 6, 7, 8, 9, 10, 11}));
}

// In files that state times, view_times specifies those of individual views.
TEST(RatedSource, FilesWithTimesAreRefused) {
  EXPECT_THROW(
      RecordingIn("a.jsonl",
                  OwnFile(R"({"frame": 1, "time": 12.0, "views": {}})"),
                  Rates({{"b", 50.0}})),
      InputError);
}

TEST(RatedSource, UnknownViewsAndUnknownRatesAreRefused) {
  DetectionSequence sequence = Counting(2, 2);
  EXPECT_THROW(Read(sequence, Rates({{"c", 25.0}})), InputError);
  sequence.header.frame_rate_hz = 0.0;
  EXPECT_THROW(Read(sequence, Rates({{"b", 25.0}})), OptionError);
}

// "view_times" is a synonym of "capture_times".
TEST(ViewTimes, AreCaptureTimes) {
  const std::string frame =
      OwnFile(R"({"frame": 300, "time": 12.0, "views": {"a": []}, )"
              R"("view_times": {"b": 12.013})");
  const DetectionSequence read = RecordingIn("a.jsonl", frame + "}");
  ASSERT_EQ(read.frames.size(), 1u);
  EXPECT_EQ(read.frames[0].views[0].capture_time, FromSeconds(12.0));
  EXPECT_EQ(read.frames[0].views[1].capture_time, FromSeconds(12.013));
  EXPECT_THROW(
      RecordingIn("b.jsonl", frame + R"(, "capture_times": {"b": 12.013}})"),
      InputError);
}

// The time of a frame that states none is its number / frame rate; it must
// ascend with the times of the other frames.
TEST(ViewTimes, FramesWithoutATimeMustFitTheOthers) {
  const std::string first = R"({"frame": 1, "time": 100.0, "views": {}})";
  const std::string error = testing::FaultOf(
      "a.jsonl", OwnFile(first + "\n" + R"({"frame": 30, "views": {}})"));
  EXPECT_THAT(error, ::testing::HasSubstr("line 3: time: found 1.2"));
  EXPECT_EQ(RecordingIn("b.jsonl", OwnFile(R"({"frame": 0, "views": {}})"
                                           "\n" +
                                           first))
                .frames.size(),
            2u);
}

// In a mirrored image, pixels are counted from the opposite side.
TEST(DetectionSource, MirroredViewsAreMirroredBack) {
  const std::string text = OwnFile(
      R"({"frame": 1, "time": 0.04, "views": {"a": [{"joints": [[10, 20, 0.9]]}], )"
      R"("b": [{"joints": [[10, 20, 0.9]]}]}})");
  DetectionReadOptions options;
  options.mirror_px = {{"b", "y719"}};
  const TemporaryFolder folder;
  const std::string path = folder.Write("a.jsonl", text);
  const DetectionSequence read = ReadDetections(path, options);
  const auto px = [&](size_t view) {
    return read.frames[0].views[view].detections[0].joints[0].px;
  };
  EXPECT_EQ(px(0), Eigen::Vector2d(10.0, 20.0));
  EXPECT_EQ(px(1), Eigen::Vector2d(10.0, 699.0));
  options.mirror_px = {{"b", "x1279"}};
  EXPECT_EQ(ReadDetections(path, options)
                .frames[0]
                .views[1]
                .detections[0]
                .joints[0]
                .px,
            Eigen::Vector2d(1269.0, 20.0));
  for (const char* bad :
       {"", "x", "719", "z719", "y-1", "y1e9", "y7x", "x0x4ff", "x 1279"}) {
    options.mirror_px = {{"b", bad}};
    EXPECT_THROW(ReadDetections(path, options), OptionError) << bad;
  }
  options.mirror_px = {{"c", "y719"}};
  EXPECT_THROW(ReadDetections(path, options), OptionError);
}

// Frames of a view whose files begin at another number are assigned to the
// frames of the other views.
TEST(RatedSource, FrameOffsetsAreSubtractedFromTheNumbersOfAView) {
  DetectionReadOptions options;
  options.view_frame_offset["b"] = 2;
  int64_t both = 0;
  for (const DetectionFrame& frame : Read(Counting(6, 6), options)) {
    const auto& views = frame.views;
    if (views[0].detections.empty() || views[1].detections.empty()) continue;
    ++both;
    EXPECT_EQ(views[1].capture_time, frame.time);
  }
  EXPECT_EQ(both, 4);  // 0..3, which are 2..5 in the files of b
}

}  // namespace
}  // namespace kinegraph
