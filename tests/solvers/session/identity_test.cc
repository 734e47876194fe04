// Who is who in a run: linking, corrections, single frames.
#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/synthetic/noise.h"
#include "core/synthetic/scene.h"
#include "solvers/session/run.h"

namespace kinegraph::testing {
namespace {

struct ExactTake {
  RunRequest request;
  DetectionSequence detections;
  TrackSequence truth;
};

// Exact detections of people who stay.
ExactTake MakeTake(int people, double duration_s) {
  SceneOptions options;
  options.seed = 5;
  options.people = people;
  options.duration_s = duration_s;
  options.cameras.count = 4;
  options.motion.visitors = 0.0;
  const Scene scene = MakeScene(options);
  ExactTake take;
  take.request.cameras = scene.cameras;
  ObservationTruth labels;
  take.detections = Observe(scene, NoiseOptions(), &labels);
  take.truth = TruthFor(scene, take.detections);
  return take;
}

// Two people for eight seconds; nobody is seen in the fourth.
ExactTake TwoHidden() {
  ExactTake take = MakeTake(2, 8.0);
  for (DetectionFrame& frame : take.detections.frames) {
    if (frame.frame < 75 || frame.frame >= 100) continue;
    for (ViewDetections& view : frame.views) view.detections.clear();
  }
  return take;
}

RunOptions GraphOptions() {
  RunOptions options;
  options.estimators.mode = Mode::kGraph;
  options.estimators.output = OutputKind::kGaussian;
  return options;
}

std::set<TrackId> IdsOf(const TrackSequence& tracks) {
  std::set<TrackId> ids;
  for (const TrackFrame& frame : tracks.frames) {
    for (const PersonPose& person : frame.people) ids.insert(person.id);
  }
  return ids;
}

TEST(SessionIdentity, LinkingMakesOnePersonOfTwoTracks) {
  const ExactTake take = TwoHidden();
  RunOptions options = GraphOptions();
  EXPECT_EQ(
      IdsOf(TrackSequenceOf(options, take.request, take.detections)).size(),
      4u);
  options.identity.link = true;
  for (const bool second_pass : {false, true}) {
    options.tracker.life.second_pass = second_pass;
    EXPECT_EQ(
        IdsOf(TrackSequenceOf(options, take.request, take.detections)).size(),
        2u);
  }
}

TEST(SessionIdentity, PaperModeDoesNotLink) {
  const ExactTake take = TwoHidden();
  RunOptions options;
  options.estimators.mode = Mode::kPaper;
  options.identity.link = true;
  EXPECT_EQ(
      IdsOf(TrackSequenceOf(options, take.request, take.detections)).size(),
      4u);
}

IdentityEdit Join(int64_t one, int64_t other) {
  IdentityEdit edit;
  edit.op = EditOp::kJoin;
  edit.persons = {TrackId(one), TrackId(other)};
  edit.place = "edits.jsonl: line 4";
  return edit;
}

TEST(SessionIdentity, CorrectionsAreAppliedAfterTracking) {
  ExactTake take = TwoHidden();
  take.request.corrections = {Join(0, 2)};
  const TrackSequence tracks =
      TrackSequenceOf(GraphOptions(), take.request, take.detections);
  EXPECT_EQ(IdsOf(tracks),
            (std::set<TrackId>{TrackId(0), TrackId(1), TrackId(3)}));
}

TEST(SessionIdentity, WhatLinkingDidItselfMayBeHandedInAgain) {
  ExactTake take = TwoHidden();
  RunOptions options = GraphOptions();
  options.identity.link = true;
  Session session(options, take.request, take.detections.header);
  MemorySource source(take.detections);
  TrackAll(&source, &session, [](TrackFrame&&) {});
  ASSERT_EQ(session.identity_edits().size(), 2u);
  take.request.corrections = session.identity_edits();
  EXPECT_EQ(
      IdsOf(TrackSequenceOf(options, take.request, take.detections)).size(),
      2u);
}

TEST(SessionIdentity, ACorrectionThatDoesNotFitNamesItsPlace) {
  ExactTake take = TwoHidden();
  take.request.corrections = {Join(0, 77)};
  try {
    TrackSequenceOf(GraphOptions(), take.request, take.detections);
    ADD_FAILURE() << "no error";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "edits.jsonl: line 4: person 77 is unknown");
  }
}

TEST(SessionIdentity, TheSecondPassFollowsNobodyIntoWhatWasDeleted) {
  ExactTake take = MakeTake(2, 4.0);
  IdentityEdit edit;
  edit.op = EditOp::kDelete;
  edit.persons = {TrackId(1)};
  edit.frames = FrameSpan{40, 60};
  take.request.corrections = {edit};
  RunOptions options = GraphOptions();
  options.tracker.life.second_pass = true;
  int frames = 0;
  for (const TrackFrame& frame :
       TrackSequenceOf(options, take.request, take.detections).frames) {
    for (const PersonPose& person : frame.people) {
      if (person.id != TrackId(1)) continue;
      ++frames;
      EXPECT_FALSE(edit.frames->Contains(frame.frame)) << frame.frame;
    }
  }
  // 100 frames without those 21 and at most three until they are confirmed.
  EXPECT_GE(frames, 100 - 21 - 3);
}

// Moments two seconds apart, handed in as if they followed each other.
ExactTake SingleFrames() {
  ExactTake take = MakeTake(3, 40.0);
  std::vector<DetectionFrame> kept;
  std::vector<TrackFrame> truth;
  const FrameClock clock(25.0);
  for (size_t f = 0; f < take.detections.frames.size(); f += 50) {
    DetectionFrame frame = take.detections.frames[f];
    frame.frame = static_cast<int64_t>(kept.size());
    frame.time = clock.TimeOf(frame.frame);
    for (ViewDetections& view : frame.views) view.capture_time = frame.time;
    truth.push_back(take.truth.frames[f]);
    truth.back().frame = frame.frame;
    kept.push_back(std::move(frame));
  }
  take.detections.frames = std::move(kept);
  take.truth.frames = std::move(truth);
  return take;
}

TEST(SessionIdentity, SingleFramesAreTakesOfTheirOwn) {
  const ExactTake take = SingleFrames();
  RunOptions options = GraphOptions();
  options.input.independent_frames = true;
  options.tracker.life.second_pass = true;
  for (const OutputKind output : {OutputKind::kGaussian, OutputKind::kBatch}) {
    options.estimators.output = output;
    const TrackSequence tracks =
        TrackSequenceOf(options, take.request, take.detections);
    size_t found = 0;
    for (const TrackFrame& frame : tracks.frames) found += frame.people.size();
    size_t there = 0;
    for (const TrackFrame& frame : take.truth.frames) {
      there += frame.people.size();
    }
    // Exact detections by four cameras: everybody is found, once.
    EXPECT_EQ(found, there);
    EXPECT_EQ(IdsOf(tracks).size(), found) << "nobody lives on";
  }
}

}  // namespace
}  // namespace kinegraph::testing
