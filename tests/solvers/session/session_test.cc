#include "solvers/session/session.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "tests/solvers/session/recordings.h"

namespace kinegraph::testing {
namespace {

constexpr double kYear_s = 365.0 * 86400.0;

// Two people, three cameras.
Recording RecordingAt(double frame_rate_hz, double duration_s) {
  SceneOptions options = Staying(1, 2, 3, duration_s);
  options.frame_rate_hz = frame_rate_hz;
  return Record(MakeScene(options));
}
Recording SmallRecording() { return RecordingAt(25.0, 2.0); }

RunOptions InPasses(bool second_pass) {
  RunOptions options = GraphMode();
  options.tracker.life.second_pass = second_pass;
  return options;
}

class SessionPasses : public ::testing::TestWithParam<bool> {};

TEST_P(SessionPasses, FrameByFrameEqualsTheWholeRecording) {
  const Recording recording = SmallRecording();
  const RunOptions options = InPasses(GetParam());
  Session session(options, recording.request, recording.detections.header);
  const TrackSequence live = FrameByFrame(recording, &session);
  EXPECT_EQ(NumbersOf(Track(recording, options)), NumbersOf(live));
  EXPECT_EQ(live.frames.size(), recording.detections.frames.size());
  EXPECT_GT(PoseCount(live), 0u);
  EXPECT_EQ(session.summary().person_frames,
            static_cast<int64_t>(PoseCount(live)));
  EXPECT_EQ(session.summary().people, static_cast<int64_t>(IdsOf(live).size()));
}

INSTANTIATE_TEST_SUITE_P(OneAndTwo, SessionPasses, ::testing::Bool());

TEST(Session, WindowReturnsFramesAfterTheLag) {
  const Recording recording = SmallRecording();
  RunOptions options = GraphMode();
  options.estimators.graph.lag_s = 0.4;  // 10 frames at 25 Hz
  Session session(options, recording.request, recording.detections.header);
  int64_t processed = 0;
  int64_t newest = -1;
  for (const DetectionFrame& frame : recording.detections.frames) {
    ++processed;
    for (const TrackFrame& done : session.Process(frame)) newest = done.frame;
    if (processed > 20) {
      EXPECT_GE(newest, frame.frame - 11);
    }
  }
  EXPECT_GT(newest, 0);
}

TEST(Session, PaperModeIgnoresConflictingKeys) {
  RunOptions options;
  options.estimators.mode = Mode::kPaper;
  options.tracker.life.second_pass = true;
  options.tracker.life.backfill = true;
  options.tracker.life.max_gap_frames = 5.0;
  options.identity.link = true;
  EXPECT_EQ(PassCount(options), 1);
  const RunOptions ruled = WithRulesOfMode(options);
  EXPECT_FALSE(ruled.tracker.life.backfill);
  EXPECT_FALSE(ruled.identity.link);
  EXPECT_EQ(ruled.tracker.life.max_gap_frames, 0.0);

  const Recording recording = SmallRecording();
  RunOptions plain;
  plain.estimators.mode = Mode::kPaper;
  EXPECT_EQ(NumbersOf(Track(recording, options)),
            NumbersOf(Track(recording, plain)));
}

TEST(Session, SkipsFramesThatWereNotRequested) {
  Recording recording = SmallRecording();
  recording.request.frames = {{10, 20}};
  Session session(GraphMode(), recording.request, recording.detections.header);
  EXPECT_FALSE(session.IsPastEnd(19));
  EXPECT_TRUE(session.IsPastEnd(20));
  const std::vector<TrackFrame> written =
      FrameByFrame(recording, &session).frames;
  ASSERT_EQ(written.size(), 10u);
  EXPECT_EQ(written.front().frame, 10);
  EXPECT_EQ(written.back().frame, 19);
}

TEST(Session, WarmUpIsProcessedButNotWritten) {
  const Recording recording = SmallRecording();
  RunOptions options = GraphMode();
  options.input.repeat_first_frame = 4;
  Session session(options, recording.request, recording.detections.header);
  int64_t fed = 0;
  session.set_frame_listener([&](const DetectionFrame&) { ++fed; });
  const std::vector<TrackFrame> written =
      FrameByFrame(recording, &session).frames;
  const auto count = static_cast<int64_t>(recording.detections.frames.size());
  EXPECT_EQ(fed, count + 4);
  EXPECT_EQ(static_cast<int64_t>(written.size()), count);
  EXPECT_EQ(written.front().frame, recording.detections.frames.front().frame);
}

TEST(Session, RejectsAnUnknownCameraByName) {
  Recording recording = SmallRecording();
  recording.request.without_cameras = {"nobody"};
  try {
    Session session(GraphMode(), recording.request,
                    recording.detections.header);
    FAIL() << "expected an InputError";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("nobody"), std::string::npos);
  }
}

// ---- Clocks that stop, step or pause ----

void Shift(double seconds, DetectionFrame* frame) {
  frame->time += FromSeconds(seconds);
  for (ViewDetections& view : frame->views) {
    view.capture_time += FromSeconds(seconds);
  }
}

// The recording with `seconds` added to all times from frame `from` on.
Recording WithPause(Recording recording, int64_t from, double seconds) {
  for (DetectionFrame& frame : recording.detections.frames) {
    if (frame.frame >= from) Shift(seconds, &frame);
  }
  return recording;
}

class Pauses : public ::testing::TestWithParam<double> {};

// A pause of an hour ends all state that is carried from frame to frame, so
// longer pauses give identical results.
TEST_P(Pauses, GiveTheResultOfAnHour) {
  const Recording recording = RecordingAt(25.0, 3.0);
  for (const bool batch : {false, true}) {
    RunOptions options = GraphMode();
    if (batch) {
      options.estimators.output = OutputKind::kBatch;
      options.identity.link = true;
      options.tracker.life.second_pass = true;
    }
    const Recording paused = WithPause(recording, 40, GetParam());
    const TrackSequence tracks = Track(paused, options);
    const TrackSequence hour = Track(WithPause(recording, 40, 3600.0), options);
    EXPECT_EQ(NumbersOf(tracks), NumbersOf(hour));
    ASSERT_EQ(tracks.frames.size(), paused.detections.frames.size());
    for (size_t k = 0; k < tracks.frames.size(); ++k) {
      EXPECT_EQ(tracks.frames[k].time, paused.detections.frames[k].time);
    }
  }
}
INSTANTIATE_TEST_SUITE_P(All, Pauses,
                         ::testing::Values(3.0 * 3600.0, kYear_s,
                                           40.0 * kYear_s));

// The part before a pause is tracked as if the recording ended there. A pause
// of -0.04 s, minus one frame, stops the clock; pauses of -0.041 s, -5 s and
// -1e6 s set it back.
TEST(SessionClock, PartBeforeAPauseIsIndependentOfTheRest) {
  const Recording recording = RecordingAt(25.0, 3.0);
  Recording alone = recording;
  alone.detections.frames.resize(40);
  const std::vector<double> expected = NumbersOf(Track(alone, GraphMode()));
  for (const double pause_s :
       {1.0, 60.0, 3600.0, kYear_s, -0.041, -5.0, -1e6, -0.04}) {
    TrackSequence tracks =
        Track(WithPause(recording, 40, pause_s), GraphMode());
    EXPECT_EQ(IdsOf(tracks).size(), 4u) << pause_s << " s: a track continued";
    tracks.frames.resize(40);
    EXPECT_EQ(NumbersOf(tracks), expected) << pause_s << " s";
  }
}

TEST(SessionClock, StoppedClockIsNotAnError) {
  Recording recording = RecordingAt(25.0, 1.0);
  for (DetectionFrame& frame : recording.detections.frames) {
    Shift(-ToSeconds(frame.time), &frame);
  }
  // Tracking restarts in every frame, so no track is confirmed.
  EXPECT_EQ(PoseCount(Track(recording, GraphMode())), 0u);
}

// Of every `on + off` frames, the first `on` have detections.
struct Pattern {
  double rate_hz = 0.0;
  int on = 0;
  int off = 0;
};

class EmptyFrames : public ::testing::TestWithParam<Pattern> {};

// A recording with frames without detections, at regular intervals, gives the
// same people as the recording without these frames.
TEST_P(EmptyFrames, DoNotChangePeople) {
  const auto [rate_hz, on, off] = GetParam();
  for (const bool backfill : {false, true}) {
    Recording with = RecordingAt(rate_hz, 6.0);
    Recording without = with;
    without.detections.frames.clear();
    for (DetectionFrame& frame : with.detections.frames) {
      if (frame.frame % (on + off) < on) {
        without.detections.frames.push_back(frame);
        continue;
      }
      for (ViewDetections& view : frame.views) view.detections.clear();
    }
    RunOptions options = GraphMode();
    options.tracker.life.backfill = backfill;
    const TrackSequence empty = Track(with, options);
    const TrackSequence left_out = Track(without, options);
    EXPECT_EQ(IdsOf(empty).size(), 2u);
    EXPECT_EQ(IdsOf(empty), IdsOf(left_out));
    // People are written only in frames with detections.
    EXPECT_EQ(PoseCount(empty), PoseCount(left_out));
  }
}
INSTANTIATE_TEST_SUITE_P(
    All, EmptyFrames,
    ::testing::Values(Pattern{25.0, 2, 1}, Pattern{25.0, 1, 1},
                      Pattern{25.0, 1, 9}, Pattern{30.0, 1, 4},
                      Pattern{60.0, 2, 1}, Pattern{60.0, 1, 1},
                      Pattern{60.0, 1, 9}, Pattern{120.0, 1, 1},
                      Pattern{120.0, 3, 1}, Pattern{120.0, 1, 9}));

class Frames : public ::testing::Test {
 protected:
  DetectionFrame At(size_t k) const { return recording_.detections.frames[k]; }
  const Recording recording_ = RecordingAt(25.0, 1.0);
};

TEST_F(Frames, AreRejectedAndSkippedIfInvalid) {
  const double nan = std::nan("");
  std::vector<DetectionFrame> wrong(7, At(5));
  wrong[0].views.pop_back();
  wrong[1].views.emplace_back();
  wrong[2].views[0].detections.at(0).joints.resize(3);
  wrong[3].views[0].detections.at(0).joints.emplace_back();
  wrong[4].views[0].detections.at(0).joints[0] = {Eigen::Vector2d(nan, 0.0),
                                                  1.0, true};
  wrong[5].views[0].capture_time += FromSeconds(1e9);
  wrong[6].frame = 2;
  Session session(GraphMode(), recording_.request,
                  recording_.detections.header);
  Recording rest = recording_;
  rest.frames().erase(rest.frames().begin(), rest.frames().begin() + 5);
  TrackSequence tracks;
  for (size_t k = 0; k < 5; ++k) {
    for (TrackFrame& one : session.Process(At(k))) {
      tracks.frames.push_back(std::move(one));
    }
  }
  for (const DetectionFrame& one : wrong) {
    EXPECT_THROW(session.Process(one), InputError);
  }
  for (TrackFrame& one : FrameByFrame(rest, &session).frames) {
    tracks.frames.push_back(std::move(one));
  }
  EXPECT_EQ(NumbersOf(tracks), NumbersOf(Track(recording_, GraphMode())));
}

TEST_F(Frames, AreRejectedDuringAnotherCallAndAfterTheEnd) {
  Session session(GraphMode(), recording_.request,
                  recording_.detections.header);
  int refused = 0;
  session.set_frame_listener([&](const DetectionFrame&) {
    // A nested call, like that of a second thread.
    try {
      session.Process(At(1));
    } catch (const std::logic_error&) {
      ++refused;
    }
  });
  session.Process(At(0));
  EXPECT_EQ(refused, 1);
  session.set_frame_listener(nullptr);
  session.Process(At(1));
  session.Finish();
  EXPECT_THROW(session.Process(At(2)), std::logic_error);
  EXPECT_THROW(session.Finish(), std::logic_error);
}

TEST_F(Frames, SessionIsUnusableAfterAnException) {
  Session session(GraphMode(), recording_.request,
                  recording_.detections.header);
  session.set_frame_listener(
      [](const DetectionFrame&) { throw std::runtime_error("stop"); });
  EXPECT_THROW(session.Process(At(0)), std::runtime_error);
  session.set_frame_listener(nullptr);
  EXPECT_THROW(session.Process(At(1)), std::logic_error);
}

}  // namespace
}  // namespace kinegraph::testing
