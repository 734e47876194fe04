// Tests identities in a run: linking, corrections, unrelated frames.
#include <gtest/gtest.h>

#include <set>
#include <vector>

#include "core/base/error.h"
#include "tests/solvers/session/recordings.h"

namespace kinegraph::testing {
namespace {

// Exact detections of people who are present throughout.
Recording MakeRecording(int people, double duration_s) {
  return Record(MakeScene(Staying(5, people, 4, duration_s)));
}

// Two people for eight seconds, without detections in the fourth second.
Recording TwoHidden() {
  Recording recording = MakeRecording(2, 8.0);
  for (DetectionFrame& frame : recording.detections.frames) {
    if (frame.frame < 75 || frame.frame >= 100) continue;
    for (ViewDetections& view : frame.views) view.detections.clear();
  }
  return recording;
}

RunOptions GraphOptions() {
  RunOptions options = GraphMode();
  options.estimators.output = OutputKind::kGaussian;
  return options;
}

TEST(SessionIdentity, LinkingMergesTracksOfOnePerson) {
  const Recording recording = TwoHidden();
  RunOptions options = GraphOptions();
  EXPECT_EQ(IdsOf(Track(recording, options)).size(), 4u);
  options.identity.link = true;
  for (const bool second_pass : {false, true}) {
    options.tracker.life.second_pass = second_pass;
    EXPECT_EQ(IdsOf(Track(recording, options)).size(), 2u);
  }
}

TEST(SessionIdentity, PaperModeDoesNotLink) {
  const Recording recording = TwoHidden();
  RunOptions options;
  options.estimators.mode = Mode::kPaper;
  options.identity.link = true;
  EXPECT_EQ(IdsOf(Track(recording, options)).size(), 4u);
}

IdentityEdit Join(int64_t one, int64_t other) {
  IdentityEdit edit;
  edit.op = EditOp::kJoin;
  edit.persons = {TrackId(one), TrackId(other)};
  edit.place = "edits.jsonl: line 4";
  return edit;
}

TEST(SessionIdentity, CorrectionsAreAppliedAfterTracking) {
  Recording recording = TwoHidden();
  recording.request.corrections = {Join(0, 2)};
  const TrackSequence tracks = Track(recording, GraphOptions());
  EXPECT_EQ(IdsOf(tracks),
            (std::set<TrackId>{TrackId(0), TrackId(1), TrackId(3)}));
}

TEST(SessionIdentity, CorrectionsThatRepeatLinkingAreAccepted) {
  Recording recording = TwoHidden();
  RunOptions options = GraphOptions();
  options.identity.link = true;
  Session session(options, recording.request, recording.detections.header);
  MemorySource source(recording.detections);
  TrackAll(&source, &session, [](TrackFrame&&) {});
  ASSERT_EQ(session.identity_edits().size(), 2u);
  recording.request.corrections = session.identity_edits();
  EXPECT_EQ(IdsOf(Track(recording, options)).size(), 2u);
}

TEST(SessionIdentity, InvalidCorrectionIsReportedWithItsLine) {
  Recording recording = TwoHidden();
  recording.request.corrections = {Join(0, 77)};
  try {
    Track(recording, GraphOptions());
    ADD_FAILURE() << "expected an InputError";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "edits.jsonl: line 4: person 77 is unknown");
  }
}

TEST(SessionIdentity, SecondPassDoesNotExtendIntoDeletedFrames) {
  Recording recording = MakeRecording(2, 4.0);
  IdentityEdit edit;
  edit.op = EditOp::kDelete;
  edit.persons = {TrackId(1)};
  edit.frames = FrameSpan{40, 60};
  recording.request.corrections = {edit};
  RunOptions options = GraphOptions();
  options.tracker.life.second_pass = true;
  int frames = 0;
  for (const TrackFrame& frame : Track(recording, options).frames) {
    for (const PersonPose& person : frame.people) {
      if (person.id != TrackId(1)) continue;
      ++frames;
      EXPECT_FALSE(edit.frames->Contains(frame.frame)) << frame.frame;
    }
  }
  // 100 frames, minus the 21 deleted frames and at most three before the tracks
  // are confirmed.
  EXPECT_GE(frames, 100 - 21 - 3);
}

TEST(SessionIdentity, DeletedFramesStayEmptyUnderAnotherIdentity) {
  Recording recording = MakeRecording(2, 4.0);
  IdentityEdit shorten;
  shorten.op = EditOp::kDelete;
  shorten.persons = {TrackId(1)};
  shorten.frames = FrameSpan{40, 60};
  IdentityEdit cut;
  cut.op = EditOp::kCut;
  cut.persons = {TrackId(1), TrackId(77)};
  cut.frames = FrameSpan{0, 39};
  recording.request.corrections = {shorten, cut, Join(77, 1)};
  RunOptions options = GraphOptions();
  options.tracker.life.second_pass = true;
  const TrackSequence tracks = Track(recording, options);
  EXPECT_EQ(IdsOf(tracks), (std::set<TrackId>{TrackId(0), TrackId(77)}));
  for (const TrackFrame& frame : tracks.frames) {
    if (!shorten.frames->Contains(frame.frame)) continue;
    ASSERT_EQ(frame.people.size(), 1u) << frame.frame;
    EXPECT_EQ(frame.people[0].id, TrackId(0));
  }
}

// Instants two seconds apart, passed as consecutive frames.
Recording SingleFrames() {
  Recording recording = MakeRecording(3, 40.0);
  std::vector<DetectionFrame> kept;
  std::vector<TrackFrame> truth;
  const FrameClock clock(25.0);
  for (size_t f = 0; f < recording.detections.frames.size(); f += 50) {
    DetectionFrame frame = recording.detections.frames[f];
    frame.frame = static_cast<int64_t>(kept.size());
    frame.time = clock.TimeOf(frame.frame);
    for (ViewDetections& view : frame.views) view.capture_time = frame.time;
    truth.push_back(recording.truth.frames[f]);
    truth.back().frame = frame.frame;
    kept.push_back(std::move(frame));
  }
  recording.detections.frames = std::move(kept);
  recording.truth.frames = std::move(truth);
  return recording;
}

TEST(SessionIdentity, IndependentFramesAreTrackedSeparately) {
  const Recording recording = SingleFrames();
  RunOptions options = GraphOptions();
  options.input.independent_frames = true;
  options.tracker.life.second_pass = true;
  for (const OutputKind output : {OutputKind::kGaussian, OutputKind::kBatch}) {
    options.estimators.output = output;
    const TrackSequence tracks = Track(recording, options);
    // Exact detections by four cameras: every person is found exactly once.
    EXPECT_EQ(PoseCount(tracks), PoseCount(recording.truth));
    EXPECT_EQ(IdsOf(tracks).size(), PoseCount(tracks)) << "a track continued";
  }
}

}  // namespace
}  // namespace kinegraph::testing
