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

// Frames 0 .. count - 1 of two views; each detection carries its frame.
class Counting : public DetectionSource {
 public:
  Counting(int64_t count_a, int64_t count_b, double rate_hz)
      : count_a_(count_a), count_b_(count_b) {
    header_.skeleton = Coco17();
    header_.view_names = {"a", "b"};
    header_.frame_rate_hz = rate_hz;
  }
  const DetectionHeader& header() const override { return header_; }
  bool Next(DetectionFrame* frame) override {
    if (next_ >= std::max(count_a_, count_b_)) return false;
    *frame = DetectionFrame();
    frame->frame = next_;
    frame->time = FrameClock(header_.frame_rate_hz).TimeOf(next_);
    frame->views.resize(2);
    for (int v = 0; v < 2; ++v) {
      frame->views[v].capture_time = frame->time;
      if (next_ >= (v == 0 ? count_a_ : count_b_)) continue;
      frame->views[v].detections.resize(1);
      frame->views[v].detections[0].index_in_file = static_cast<int>(next_);
    }
    ++next_;
    return true;
  }

 private:
  DetectionHeader header_;
  int64_t count_a_;
  int64_t count_b_;
  int64_t next_ = 0;
};

// At 25 Hz, and what `edit` makes of each.
class Edited final : public Counting {
 public:
  Edited(int64_t count, void (*edit)(DetectionFrame* frame))
      : Counting(count, count, 25.0), edit_(edit) {}
  bool Next(DetectionFrame* frame) override {
    const bool any = Counting::Next(frame);
    if (any) edit_(frame);
    return any;
  }

 private:
  void (*edit_)(DetectionFrame* frame);
};

std::vector<int64_t> NumbersOf(DetectionSource* source) {
  std::vector<int64_t> numbers;
  DetectionFrame frame;
  while (source->Next(&frame)) numbers.push_back(frame.frame);
  return numbers;
}

DetectionReadOptions Rates(const std::map<std::string, double>& rates_hz) {
  DetectionReadOptions options;
  options.view_frame_rate_hz = rates_hz;
  return options;
}

std::vector<DetectionFrame> Read(int64_t count_a, int64_t count_b,
                                 const std::map<std::string, double>& rates_hz,
                                 double recording_hz = 25.0) {
  const auto source = OpenRated(
      [=] {
        return std::make_unique<Counting>(count_a, count_b, recording_hz);
      },
      Rates(rates_hz));
  std::vector<DetectionFrame> frames;
  DetectionFrame frame;
  while (source->Next(&frame)) frames.push_back(frame);
  return frames;
}

TEST(RatedSource, AViewTwiceAsFastGivesEverySecondFrame) {
  const std::vector<DetectionFrame> frames = Read(10, 20, {{"b", 50.0}});
  ASSERT_EQ(frames.size(), 10u);
  for (int k = 0; k < 10; ++k) {
    ASSERT_EQ(frames[k].views[1].detections.size(), 1u);
    EXPECT_EQ(frames[k].views[1].detections[0].index_in_file, 2 * k);
    EXPECT_EQ(frames[k].views[1].capture_time, frames[k].time);
  }
}

// Limits hold for views of their own rates, too.
TEST(RatedSource, LimitsHold) {
  const testing::TemporaryFolder folder;
  const std::string path = folder.Write(
      "d.jsonl",
      R"({"kinegraph_detections": 1, "skeleton": {"name": "s", "joints": ["a"], )"
      R"("bones": []}, "frame_rate": 25, "views": ["a", "b"]})"
      "\n"
      R"({"frame": 0, "views": {"a": [{"joints": [[1, 2, 1]]}], )"
      R"("b": [{"joints": [[1, 2, 1]]}]}})"
      "\n");
  DetectionReadOptions options;
  options.frame_rate_hz = 25.0;
  options.view_frame_rate_hz["a"] = 25.0;
  EXPECT_EQ(ReadDetections(path, options).frames.size(), 1u);
  options.max_per_frame = 1;
  EXPECT_THROW(ReadDetections(path, options), InputError);
}

TEST(RatedSource, ASlowViewLeavesFramesOut) {
  // 10 Hz at 25 Hz: its frames are 2.5 of the recording's apart.
  const std::vector<DetectionFrame> frames = Read(10, 4, {{"b", 10.0}});
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
      Read(20, 10, {{"a", 50.0}, {"b", 25.0}}, 100.0);
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
  const auto source = OpenRated(
      [] {
        return std::make_unique<Edited>(8, [](DetectionFrame* frame) {
          if (frame->frame < 2 || frame->frame >= 5) return;
          for (ViewDetections& view : frame->views) view.detections.clear();
        });
      },
      Rates({{"b", 50.0}}));
  EXPECT_EQ(NumbersOf(source.get()),
            (std::vector<int64_t>{0, 1, 2, 3, 4, 5, 6, 7}));
}

// Numbers that only the files of another rate have are no frames of the
// recording.
TEST(RatedSource, NumbersBeforeTheFirstFrameAreNone) {
  // 25 Hz from frame 4 on. Files of b count at 50 Hz: its 8 is the
  // recording's 4.
  const auto source = OpenRated(
      [] {
        return std::make_unique<Edited>(12, [](DetectionFrame* frame) {
          if (frame->frame < 4) frame->views[0].detections.clear();
          if (frame->frame < 8) frame->views[1].detections.clear();
        });
      },
      Rates({{"b", 50.0}}));
  EXPECT_EQ(NumbersOf(source.get()),
            (std::vector<int64_t>{4, 5, 6, 7, 8, 9, 10, 11}));
}

// Files with times of their own have view_times.
TEST(RatedSource, FilesThatTellTimesAreRefused) {
  const testing::TemporaryFolder folder;
  const std::string path = folder.Write(
      "a.jsonl",
      R"({"kinegraph_detections": 1, "skeleton": {"name": "s", "joints": ["a"], )"
      R"("bones": []}, "frame_rate": 25.0, "views": ["a", "b"]})"
      "\n"
      R"({"frame": 1, "time": 12.0, "views": {}})");
  DetectionReadOptions options;
  options.view_frame_rate_hz["b"] = 50.0;
  EXPECT_THROW(ReadDetections(path, options), InputError);
}

TEST(RatedSource, UnknownViewsAndUnknownRatesAreRefused) {
  const auto open = [] { return std::make_unique<Counting>(2, 2, 25.0); };
  EXPECT_THROW(OpenRated(open, Rates({{"c", 25.0}})), InputError);
  EXPECT_THROW(OpenRated([] { return std::make_unique<Counting>(2, 2, 0.0); },
                         Rates({{"b", 25.0}})),
               OptionError);
}

// "view_times" is another word for "capture_times".
TEST(ViewTimes, AreTimesOfCapture) {
  const testing::TemporaryFolder folder;
  const std::string header =
      R"({"kinegraph_detections": 1, "skeleton": {"name": "s", "joints": ["a"], )"
      R"("bones": []}, "frame_rate": 25.0, "views": ["cam0", "cam1"]})";
  const std::string frame =
      R"({"frame": 300, "time": 12.0, "views": {"cam0": []}, )";
  const std::string path = folder.Write(
      "a.jsonl", header + "\n" + frame + R"("view_times": {"cam1": 12.013}})");
  const DetectionSequence read = ReadDetections(path);
  ASSERT_EQ(read.frames.size(), 1u);
  EXPECT_EQ(read.frames[0].views[0].capture_time, FromSeconds(12.0));
  EXPECT_EQ(read.frames[0].views[1].capture_time, FromSeconds(12.013));
  EXPECT_THROW(ReadDetections(folder.Write(
                   "b.jsonl", header + "\n" + frame +
                                  R"("view_times": {"cam1": 12.013}, )"
                                  R"("capture_times": {"cam1": 12.013}})")),
               InputError);
}

// A view whose files begin at another number joins the frames of the others.
TEST(RatedSource, OffsetsAreTakenFromTheNumbersOfAView) {
  DetectionReadOptions options;
  options.view_frame_offset["b"] = 2;
  const auto source =
      OpenRated([] { return std::make_unique<Counting>(6, 6, 25.0); }, options);
  DetectionFrame frame;
  int64_t both = 0;
  while (source->Next(&frame)) {
    const auto& views = frame.views;
    if (views[0].detections.empty() || views[1].detections.empty()) continue;
    ++both;
    EXPECT_EQ(views[1].capture_time, frame.time);
  }
  EXPECT_EQ(both, 4);  // 0..3, which b calls 2..5
}

}  // namespace
}  // namespace kinegraph
