#include "solvers/session/recording_clock.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/synthetic/noise.h"
#include "core/synthetic/scene.h"
#include "solvers/session/run.h"

namespace kinegraph::testing {
namespace {

constexpr double kYear_s = 365.0 * 86400.0;

struct ClockRecording {
  RunRequest request;
  DetectionSequence detections;
};

// Two people who stay, three cameras.
ClockRecording TakeAt(double frame_rate_hz, double duration_s) {
  SceneOptions options;
  options.people = 2;
  options.motion.visitors = 0;
  options.duration_s = duration_s;
  options.frame_rate_hz = frame_rate_hz;
  options.cameras.count = 3;
  const Scene scene = MakeScene(options);
  ClockRecording recording;
  recording.request.cameras = scene.cameras;
  ObservationTruth labels;
  recording.detections = Observe(scene, NoiseOptions(), &labels);
  return recording;
}

RunOptions GraphMode() {
  RunOptions options;
  options.estimators.mode = Mode::kGraph;
  return options;
}

void Shift(double seconds, DetectionFrame* frame) {
  frame->time += FromSeconds(seconds);
  for (ViewDetections& view : frame->views) {
    view.capture_time += FromSeconds(seconds);
  }
}

// `take` with `seconds` put on all times from frame `from` on.
ClockRecording WithPause(ClockRecording recording, int64_t from,
                         double seconds) {
  for (DetectionFrame& frame : recording.detections.frames) {
    if (frame.frame >= from) Shift(seconds, &frame);
  }
  return recording;
}

TrackSequence Track(const ClockRecording& recording,
                    const RunOptions& options) {
  return TrackSequenceOf(options, recording.request, recording.detections);
}

std::vector<double> Positions(const TrackSequence& tracks) {
  std::vector<double> numbers;
  for (const TrackFrame& frame : tracks.frames) {
    for (const PersonPose& person : frame.people) {
      for (const Joint3d& joint : person.joints) {
        if (!joint.present()) continue;
        for (int i = 0; i < 3; ++i) numbers.push_back(joint.position_m[i]);
      }
      for (const auto& covariance : person.covariances) {
        numbers.push_back(covariance.has_value() ? covariance->trace() : 0.0);
      }
    }
  }
  return numbers;
}

std::set<TrackId> People(const TrackSequence& tracks) {
  std::set<TrackId> people;
  for (const TrackFrame& frame : tracks.frames) {
    for (const PersonPose& person : frame.people) people.insert(person.id);
  }
  return people;
}

size_t Poses(const TrackSequence& tracks) {
  size_t poses = 0;
  for (const TrackFrame& frame : tracks.frames) poses += frame.people.size();
  return poses;
}

class Pauses : public ::testing::TestWithParam<double> {};

// A pause of an hour ends everything that lives on from frame to frame, and a
// longer one no more than that: the same bits.
TEST_P(Pauses, AreTrackedAsAnHourIs) {
  const ClockRecording recording = TakeAt(25.0, 3.0);
  for (const bool batch : {false, true}) {
    RunOptions options = GraphMode();
    if (batch) {
      options.estimators.output = OutputKind::kBatch;
      options.identity.link = true;
      options.tracker.life.second_pass = true;
    }
    const ClockRecording paused = WithPause(recording, 40, GetParam());
    const TrackSequence tracks = Track(paused, options);
    const TrackSequence hour = Track(WithPause(recording, 40, 3600.0), options);
    EXPECT_EQ(Positions(tracks), Positions(hour));
    EXPECT_EQ(People(tracks), People(hour));
    ASSERT_EQ(tracks.frames.size(), paused.detections.frames.size());
    for (size_t k = 0; k < tracks.frames.size(); ++k) {
      EXPECT_EQ(tracks.frames[k].time, paused.detections.frames[k].time);
    }
  }
}
INSTANTIATE_TEST_SUITE_P(All, Pauses,
                         ::testing::Values(3.0 * 3600.0, kYear_s,
                                           40.0 * kYear_s));

// What stands before a pause of any length is what it is alone.
TEST(RecordingClockTest, ThePartBeforeAPauseIsAsItIsAlone) {
  const ClockRecording recording = TakeAt(25.0, 3.0);
  ClockRecording alone = recording;
  alone.detections.frames.resize(40);
  const std::vector<double> expected = Positions(Track(alone, GraphMode()));
  for (const double pause_s :
       {1.0, 60.0, 3600.0, kYear_s, -0.041, -5.0, -1e6, -0.04}) {
    TrackSequence tracks =
        Track(WithPause(recording, 40, pause_s), GraphMode());
    EXPECT_EQ(People(tracks).size(), 4u) << pause_s << " s: nobody lives on";
    tracks.frames.resize(40);
    EXPECT_EQ(Positions(tracks), expected) << pause_s << " s";
  }
}

TEST(RecordingClockTest, AClockThatStandsForEverIsNoError) {
  ClockRecording recording = TakeAt(25.0, 1.0);
  for (DetectionFrame& frame : recording.detections.frames) {
    Shift(-ToSeconds(frame.time), &frame);
  }
  // Every frame is a start of its own: nobody is ever confirmed.
  EXPECT_EQ(Poses(Track(recording, GraphMode())), 0u);
}

struct Pattern {
  double rate_hz = 0.0;
  int on = 0;
  int off = 0;
};

class Looks : public ::testing::TestWithParam<Pattern> {};

// Frames without anybody in any view, every so often: the people are those of
// the same recording without these frames.
TEST_P(Looks, FramesWithoutALookChangeNobody) {
  const auto [rate_hz, on, off] = GetParam();
  for (const bool backfill : {false, true}) {
    ClockRecording with = TakeAt(rate_hz, 6.0);
    ClockRecording without = with;
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
    EXPECT_EQ(People(empty).size(), 2u);
    EXPECT_EQ(People(empty), People(left_out));
    // Written are the frames in which somebody was seen.
    EXPECT_EQ(Poses(empty), Poses(left_out));
  }
}
INSTANTIATE_TEST_SUITE_P(
    All, Looks,
    ::testing::Values(Pattern{25.0, 2, 1}, Pattern{25.0, 1, 1},
                      Pattern{25.0, 1, 9}, Pattern{30.0, 1, 4},
                      Pattern{60.0, 2, 1}, Pattern{60.0, 1, 1},
                      Pattern{60.0, 1, 9}, Pattern{120.0, 1, 1},
                      Pattern{120.0, 3, 1}, Pattern{120.0, 1, 9}));

class Frames : public ::testing::Test {
 protected:
  DetectionFrame At(size_t k) const { return recording_.detections.frames[k]; }
  const ClockRecording recording_ = TakeAt(25.0, 1.0);
};

TEST_F(Frames, ThatAreNotAsTheHeaderSaysAreRefusedAndPassedOver) {
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
  const auto numbers = [&](bool with_wrong) {
    Session session(GraphMode(), recording_.request,
                    recording_.detections.header);
    TrackSequence tracks;
    const auto append = [&](std::vector<TrackFrame> frames) {
      for (TrackFrame& one : frames) tracks.frames.push_back(std::move(one));
    };
    for (size_t k = 0; k < recording_.detections.frames.size(); ++k) {
      if (with_wrong && k == 5) {
        for (const DetectionFrame& one : wrong) {
          EXPECT_THROW(session.Process(one), InputError);
        }
      }
      append(session.Process(At(k)));
    }
    append(session.Finish());
    return Positions(tracks);
  };
  EXPECT_EQ(numbers(true), numbers(false));
}

TEST_F(Frames, AreTakenByOneCallAtATimeAndNotAfterTheEnd) {
  Session session(GraphMode(), recording_.request,
                  recording_.detections.header);
  int refused = 0;
  session.set_frame_listener([&](const DetectionFrame&) {
    // A call inside another, as a second thread's would be.
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

TEST_F(Frames, OfACallThatWasStoppedEndTheSession) {
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
