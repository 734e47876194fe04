#include "solvers/session/session.h"

#include <gtest/gtest.h>

#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/synthetic/noise.h"
#include "core/synthetic/scene.h"
#include "solvers/session/run.h"

namespace kinegraph::testing {
namespace {

struct Take {
  RunRequest request;
  DetectionSequence detections;
};

// Two people, three cameras, two seconds at 25 Hz.
Take SmallRecording() {
  SceneOptions options;
  options.people = 2;
  options.duration_s = 2.0;
  options.cameras.count = 3;
  const Scene scene = MakeScene(options);
  Take recording;
  recording.request.cameras = scene.cameras;
  ObservationTruth labels;
  recording.detections = Observe(scene, NoiseOptions(), &labels);
  return recording;
}

RunOptions GraphOptionsOf(bool second_pass) {
  RunOptions options;
  options.estimators.mode = Mode::kGraph;
  options.tracker.life.second_pass = second_pass;
  return options;
}

// Every number of the poses, frame by frame: what must be the same.
std::vector<double> NumbersOf(const std::vector<TrackFrame>& frames) {
  std::vector<double> numbers;
  for (const TrackFrame& frame : frames) {
    numbers.push_back(static_cast<double>(frame.frame));
    for (const PersonPose& person : frame.people) {
      numbers.push_back(static_cast<double>(person.id.value()));
      for (const Joint3d& joint : person.joints) {
        numbers.push_back(static_cast<double>(joint.status));
        if (!joint.present()) continue;
        for (int i = 0; i < 3; ++i) numbers.push_back(joint.position_m[i]);
      }
    }
  }
  return numbers;
}

std::vector<TrackFrame> FrameByFrame(const Take& recording, Session* session) {
  std::vector<TrackFrame> written;
  const auto append = [&](std::vector<TrackFrame> frames) {
    for (TrackFrame& frame : frames) written.push_back(std::move(frame));
  };
  for (const DetectionFrame& frame : recording.detections.frames) {
    append(session->Process(frame));
  }
  append(session->Finish());
  return written;
}

class SessionPasses : public ::testing::TestWithParam<bool> {};

TEST_P(SessionPasses, FramesFromMemoryGiveWhatAWholeTakeGives) {
  const Take recording = SmallRecording();
  const RunOptions options = GraphOptionsOf(GetParam());
  Session session(options, recording.request, recording.detections.header);
  const std::vector<TrackFrame> live = FrameByFrame(recording, &session);
  const TrackSequence whole =
      TrackSequenceOf(options, recording.request, recording.detections);
  const std::vector<double> numbers = NumbersOf(live);
  EXPECT_EQ(NumbersOf(whole.frames), numbers);
  EXPECT_EQ(live.size(), recording.detections.frames.size());
  std::set<TrackId> people;
  int64_t person_frames = 0;
  for (const TrackFrame& frame : live) {
    for (const PersonPose& person : frame.people) people.insert(person.id);
    person_frames += static_cast<int64_t>(frame.people.size());
  }
  EXPECT_GT(person_frames, 0);
  EXPECT_EQ(session.summary().person_frames, person_frames);
  EXPECT_EQ(session.summary().people, static_cast<int64_t>(people.size()));
}

INSTANTIATE_TEST_SUITE_P(OneAndTwo, SessionPasses, ::testing::Bool());

TEST(Session, WindowGivesFramesAfterItsLag) {
  const Take recording = SmallRecording();
  RunOptions options = GraphOptionsOf(false);
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

TEST(Session, PaperModeKeepsItsRulesWhateverTheKeysSay) {
  RunOptions options;
  options.estimators.mode = Mode::kPaper;
  options.tracker.life.second_pass = true;
  options.tracker.life.backfill = true;
  options.tracker.life.max_gap_frames = 5.0;
  EXPECT_EQ(PassCount(options), 1);
  const RunOptions ruled = WithRulesOfMode(options);
  EXPECT_FALSE(ruled.tracker.life.backfill);
  EXPECT_EQ(ruled.tracker.life.max_gap_frames, 0.0);

  const Take recording = SmallRecording();
  RunOptions plain;
  plain.estimators.mode = Mode::kPaper;
  EXPECT_EQ(
      NumbersOf(
          TrackSequenceOf(options, recording.request, recording.detections)
              .frames),
      NumbersOf(TrackSequenceOf(plain, recording.request, recording.detections)
                    .frames));
}

TEST(Session, PassesOverFramesThatWereNotAskedFor) {
  Take recording = SmallRecording();
  recording.request.frames = {{10, 20}};
  Session session(GraphOptionsOf(false), recording.request,
                  recording.detections.header);
  EXPECT_FALSE(session.IsPastEnd(19));
  EXPECT_TRUE(session.IsPastEnd(20));
  const std::vector<TrackFrame> written = FrameByFrame(recording, &session);
  ASSERT_EQ(written.size(), 10u);
  EXPECT_EQ(written.front().frame, 10);
  EXPECT_EQ(written.back().frame, 19);
}

TEST(Session, WarmUpIsFedButNotWritten) {
  const Take recording = SmallRecording();
  RunOptions options = GraphOptionsOf(false);
  options.input.repeat_first_frame = 4;
  Session session(options, recording.request, recording.detections.header);
  int64_t fed = 0;
  session.set_frame_listener([&](const DetectionFrame&) { ++fed; });
  const std::vector<TrackFrame> written = FrameByFrame(recording, &session);
  const auto count = static_cast<int64_t>(recording.detections.frames.size());
  EXPECT_EQ(fed, count + 4);
  EXPECT_EQ(static_cast<int64_t>(written.size()), count);
  EXPECT_EQ(written.front().frame, recording.detections.frames.front().frame);
}

TEST(Session, RefusesFramesThatDoNotAscend) {
  const Take recording = SmallRecording();
  Session session(GraphOptionsOf(false), recording.request,
                  recording.detections.header);
  session.Process(recording.detections.frames[1]);
  EXPECT_THROW(session.Process(recording.detections.frames[0]), InputError);
}

TEST(Session, RefusesAUnknownCameraByName) {
  Take recording = SmallRecording();
  recording.request.without_cameras = {"nobody"};
  try {
    Session session(GraphOptionsOf(false), recording.request,
                    recording.detections.header);
    FAIL() << "nothing was thrown";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("nobody"), std::string::npos);
  }
}

}  // namespace
}  // namespace kinegraph::testing
