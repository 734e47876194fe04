#include "core/io/detections/rated_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "tests/core/io/detections/detection_files.h"

namespace kinegraph {
namespace {

using testing::RecordingIn;

// Frames 0 .. count - 1 of two views; each detection carries its frame.
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

// Our own file of two views at 25 Hz and one joint, with these frames.
std::string OwnFile(const std::string& frames) {
  return R"({"kinegraph_detections": 1, "skeleton": {"name": "s", )"
         R"("joints": ["a"], "bones": []}, "frame_rate": 25, )"
         R"("views": ["a", "b"]})"
         "\n" +
         frames;
}

TEST(RatedSource, AViewTwiceAsFastGivesEverySecondFrame) {
  const std::vector<DetectionFrame> frames =
      Read(Counting(10, 20), Rates({{"b", 50.0}}));
  ASSERT_EQ(frames.size(), 10u);
  for (int k = 0; k < 10; ++k) {
    ASSERT_EQ(frames[k].views[1].detections.size(), 1u);
    EXPECT_EQ(frames[k].views[1].detections[0].index_in_file, 2 * k);
    EXPECT_EQ(frames[k].views[1].capture_time, frames[k].time);
  }
}

// Limits hold for views of their own rates, too.
TEST(RatedSource, LimitsHold) {
  const std::string text =
      OwnFile(R"({"frame": 0, "views": {"a": [{"joints": [[1, 2, 1]]}], )"
              R"("b": [{"joints": [[1, 2, 1]]}]}})");
  DetectionReadOptions options = Rates({{"a", 25.0}});
  options.frame_rate_hz = 25.0;
  EXPECT_EQ(RecordingIn("d.jsonl", text, options).frames.size(), 1u);
  options.max_per_frame = 1;
  EXPECT_THROW(RecordingIn("d.jsonl", text, options), InputError);
}

TEST(RatedSource, ASlowViewLeavesFramesOut) {
  // 10 Hz at 25 Hz: its frames are 2.5 of the recording's apart.
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
    // Half a frame of the recording at most.
    EXPECT_LE(std::abs(view.capture_time - frame.time), FromSeconds(0.02));
  }
  EXPECT_EQ(found, (std::vector<int>{0, 1, 2, 3}));
}

// At 100 Hz, views of 50 and 25 Hz fill every second and fourth frame, to the
// end of both; what the base counts at its own rate would end after half.
TEST(RatedSource, ATakeFasterThanItsViewsLosesNothing) {
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

// Frames in which nobody is seen are frames, but for those behind the end.
TEST(RatedSource, EmptyFramesStay) {
  DetectionSequence sequence = Counting(8, 8);
  for (size_t f = 2; f < 5; ++f) {
    for (auto& view : sequence.frames[f].views) view.detections.clear();
  }
  EXPECT_EQ(NumbersOf(sequence, Rates({{"b", 50.0}})),
            (std::vector<int64_t>{0, 1, 2, 3, 4, 5, 6, 7}));
}

// Numbers that only the files of another rate have are no frames of the
// recording.
TEST(RatedSource, NumbersBeforeTheFirstFrameAreNone) {
  // 25 Hz from frame 4 on. Files of b count at 50 Hz: its 8 is the
  // recording's 4.
  DetectionSequence sequence = Counting(12, 12);
  for (size_t f = 0; f < 8; ++f) {
    if (f < 4) sequence.frames[f].views[0].detections.clear();
    sequence.frames[f].views[1].detections.clear();
  }
  EXPECT_EQ(NumbersOf(sequence, Rates({{"b", 50.0}})),
            (std::vector<int64_t>{4, 5, 6, 7, 8, 9, 10, 11}));
}

// Files with times of their own have view_times.
TEST(RatedSource, FilesThatTellTimesAreRefused) {
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

// "view_times" is another word for "capture_times".
TEST(ViewTimes, AreTimesOfCapture) {
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

// A view whose files begin at another number joins the frames of the others.
TEST(RatedSource, OffsetsAreTakenFromTheNumbersOfAView) {
  DetectionReadOptions options;
  options.view_frame_offset["b"] = 2;
  int64_t both = 0;
  for (const DetectionFrame& frame : Read(Counting(6, 6), options)) {
    const auto& views = frame.views;
    if (views[0].detections.empty() || views[1].detections.empty()) continue;
    ++both;
    EXPECT_EQ(views[1].capture_time, frame.time);
  }
  EXPECT_EQ(both, 4);  // 0..3, which b calls 2..5
}

}  // namespace
}  // namespace kinegraph
