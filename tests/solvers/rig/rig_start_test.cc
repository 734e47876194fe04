// Tests the initial estimate of a rig from exact detections, and the people
// that follow from given matches.
#include "solvers/rig/rig_start.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "core/base/time.h"
#include "solvers/cameras/camera_change.h"
#include "solvers/scene/clock_search.h"
#include "tests/support/moving_people.h"

namespace kinegraph {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::kMovingRateHz;
using testing::MovingPerson;
using testing::PoseBetween;

// Exact points determine poses to 1e-8 (view_pairs_test.cc); two poses in a
// chain, and weakly determined directions, need a larger tolerance.
constexpr double kExactPlaces = 1e-5;
constexpr int kStartFrames = 100;

std::vector<Pose3d> MovingPeople(int frame) {
  return {MovingPerson(0, frame), MovingPerson(1, frame)};
}

CameraRig IntrinsicsOf(const CameraRig& cameras) {
  return Edited(cameras, [](CameraParameters* camera) {
    camera->R.setIdentity();
    camera->t.setZero();
  });
}

// Removes all detections of these views.
DetectionSequence Blinded(DetectionSequence recording,
                          const std::vector<int>& views) {
  for (DetectionFrame& frame : recording.frames) {
    for (const int v : views) frame.views[v].detections.clear();
  }
  return recording;
}

DetectionSequence SeenByRing(int views) {
  return testing::SeenBy(testing::RingOfCameras(views), kStartFrames,
                         MovingPeople);
}

RigSearch ShortLags() {
  RigSearch search;
  search.longest_lag_s = 0.5;
  return search;
}

// ---- Parts of a recording ----

TEST(OfViews, SelectsViewsInTheGivenOrder) {
  DetectionSequence recording = SeenByRing(3);
  recording.frames.resize(4);
  const DetectionSequence part = OfViews(recording, {2, 0});
  EXPECT_THAT(part.header.view_names, ElementsAre("cam2", "cam0"));
  EXPECT_EQ(part.header.frame_rate_hz, recording.header.frame_rate_hz);
  ASSERT_EQ(part.frames.size(), 4u);
  for (size_t k = 0; k < 4; ++k) {
    EXPECT_EQ(part.frames[k].frame, recording.frames[k].frame);
    EXPECT_EQ(part.frames[k].time, recording.frames[k].time);
    ASSERT_EQ(part.frames[k].views.size(), 2u);
    const std::vector<size_t> taken = {2, 0};
    for (size_t v = 0; v < 2; ++v) {
      EXPECT_EQ(part.frames[k].views[v].detections[1].joints[9].px,
                recording.frames[k].views[taken[v]].detections[1].joints[9].px);
    }
  }
  const DetectionSequence none = OfViews(recording, {});
  EXPECT_THAT(none.header.view_names, IsEmpty());
  EXPECT_EQ(none.frames.size(), 4u);
}

// A score is the mean of 1 - d / (s / 10), with d the distance of joints from
// the epipolar lines, here about 1e-12 px, and s the size of a person, a few
// hundred pixels.
TEST(AgreementsOfViews, AreOneForExactPeople) {
  const CameraRig cameras = testing::RingOfCameras(3);
  for (const double score : AgreementsOfViews(cameras, SeenByRing(3))) {
    EXPECT_NEAR(score, 1.0, 1e-9);
  }
}

TEST(AgreementsOfViews, AreZeroForAnEmptyView) {
  const std::vector<double> scores =
      AgreementsOfViews(testing::RingOfCameras(3), Blinded(SeenByRing(3), {1}));
  EXPECT_NEAR(scores[0], 1.0, 1e-9);
  EXPECT_EQ(scores[1], 0.0);
  EXPECT_NEAR(scores[2], 1.0, 1e-9);
}

// Two coincident cameras have no agreement, but each agrees with the third.
TEST(AgreementsOfViews, AreHalfIfOneOfTwoOtherCamerasCoincides) {
  const CameraRig ring = testing::RingOfCameras(3);
  const CameraRig cameras = {ring[0], ring[1], ring[0]};
  const DetectionSequence seen =
      testing::SeenBy(cameras, kStartFrames, MovingPeople);
  const std::vector<double> scores = AgreementsOfViews(cameras, seen);
  EXPECT_NEAR(scores[0], 0.5, 1e-9);
  EXPECT_NEAR(scores[1], 1.0, 1e-9);
  EXPECT_NEAR(scores[2], 0.5, 1e-9);
}

// ---- The start of a rig ----

// Checks rotations and directions against the truth. The three cameras are
// equally far from each other, so each distance is one baseline.
void ExpectRing(const RigStart& start) {
  const CameraRig truth = testing::RingOfCameras(3);
  ASSERT_THAT(start.views, ElementsAre(0, 1, 2));
  ASSERT_EQ(start.cameras.size(), 3u);
  for (size_t a = 0; a < 3; ++a) {
    for (size_t b = a + 1; b < 3; ++b) {
      const RelativePose found =
          PoseBetween(start.cameras[a], start.cameras[b]);
      const RelativePose right = PoseBetween(truth[a], truth[b]);
      EXPECT_LT((found.R - right.R).norm(), kExactPlaces);
      EXPECT_LT((found.t - right.t).norm(), kExactPlaces);
      EXPECT_NEAR(
          (start.cameras[a].centre() - start.cameras[b].centre()).norm(), 1.0,
          kExactPlaces);
    }
  }
}

TEST(RigStart, ExactPeopleDetermineCamerasInBaselines) {
  const RigStart start = FindRigStart(
      SeenByRing(3), IntrinsicsOf(testing::RingOfCameras(3)), ShortLags());
  ExpectRing(start);
  EXPECT_THAT(start.lag_frames, ElementsAre(0, 0, 0));
  EXPECT_EQ(start.pairs.size(), 3u);
}

// Frames of a view shifted by -6 (Realigned) give it a lag of 6 frames.
TEST(RigStart, LagsAreRecovered) {
  const DetectionSequence recording = Realigned(SeenByRing(3), {0, -6, 4});
  const RigStart start = FindRigStart(
      recording, IntrinsicsOf(testing::RingOfCameras(3)), ShortLags());
  ExpectRing(start);
  ASSERT_EQ(start.lag_frames.size(), 3u);
  EXPECT_EQ(start.lag_frames[1] - start.lag_frames[0], 6);
  EXPECT_EQ(start.lag_frames[2] - start.lag_frames[0], -4);
}

// Of four cameras on a circle, neighbours are closer to each other than
// opposite cameras by a factor of sqrt(2).
TEST(RigStart, DistancesHaveACommonScale) {
  const CameraRig truth = testing::RingOfCameras(4);
  const RigStart start =
      FindRigStart(SeenByRing(4), IntrinsicsOf(truth), ShortLags());
  ASSERT_THAT(start.views, ElementsAre(0, 1, 2, 3));
  const auto apart = [](const CameraRig& cameras, size_t a, size_t b) {
    return (cameras[a].centre() - cameras[b].centre()).norm();
  };
  const double baseline = apart(truth, 0, 1) / apart(start.cameras, 0, 1);
  for (size_t a = 0; a < 4; ++a) {
    for (size_t b = a + 1; b < 4; ++b) {
      EXPECT_NEAR(apart(start.cameras, a, b) * baseline / apart(truth, a, b),
                  1.0, kExactPlaces);
    }
  }
}

TEST(RigStart, EmptyViewIsNotJoined) {
  const CameraRig truth = testing::RingOfCameras(4);
  const RigStart start = FindRigStart(Blinded(SeenByRing(4), {1}),
                                      IntrinsicsOf(truth), ShortLags());
  EXPECT_THAT(start.views, ElementsAre(0, 2, 3));
  ASSERT_EQ(start.cameras.size(), 3u);
  EXPECT_EQ(start.cameras[1].name(), "cam2");
  EXPECT_EQ(start.lag_frames.size(), 3u);
  EXPECT_EQ(start.pairs.size(), 6u);
}

TEST(RigStart, HasNoViewsIfFewerThanTwoSeePeople) {
  const CameraRig truth = testing::RingOfCameras(3);
  std::vector<std::pair<int, int>> steps;
  RigSearch search = ShortLags();
  search.progress = [&](int done, int total) {
    steps.emplace_back(done, total);
  };
  const RigStart start =
      FindRigStart(Blinded(SeenByRing(3), {0, 2}), IntrinsicsOf(truth), search);
  EXPECT_THAT(start.views, IsEmpty());
  EXPECT_THAT(start.cameras, IsEmpty());
  EXPECT_THAT(start.lag_frames, IsEmpty());
  // The tracklets and pairs of the search are returned nevertheless.
  EXPECT_FALSE(start.tracklets.empty());
  EXPECT_EQ(start.pairs.size(), 3u);
  using Step = std::pair<int, int>;
  EXPECT_THAT(steps, ElementsAre(Step(1, 3), Step(2, 3), Step(3, 3)));
}

// ---- People from matches ----

// Three views with two detections each; index_in_file encodes view, frame and
// detection.
DetectionSequence Numbered(int frames) {
  DetectionSequence recording;
  recording.header.skeleton = Coco17();
  recording.header.view_names = {"a", "b", "c"};
  recording.header.frame_rate_hz = kMovingRateHz;
  for (int k = 0; k < frames; ++k) {
    DetectionFrame& frame = recording.frames.emplace_back();
    frame.frame = 100 + k;
    frame.time = FrameClock(kMovingRateHz).TimeOf(frame.frame);
    frame.views.resize(3);
    for (int v = 0; v < 3; ++v) {
      frame.views[v].detections.resize(2);
      for (int d = 0; d < 2; ++d) {
        frame.views[v].detections[d].index_in_file = 1000 * v + 10 * k + d;
      }
    }
  }
  return recording;
}

ViewTracklet TrackletAt(int view, int first, int end, int detection = 0) {
  ViewTracklet tracklet;
  tracklet.view = view;
  tracklet.first = first;
  tracklet.detections.assign(end - first, detection);
  tracklet.joints.resize(end - first);
  return tracklet;
}

PairFit MatchedPair(int a, int b, std::vector<TrackletMatch> matches,
                    int lag = 0) {
  PairFit pair;
  pair.a = a;
  pair.b = b;
  pair.lag = lag;
  pair.matches = std::move(matches);
  return pair;
}

RigStart StartOf(std::vector<ViewTracklet> tracklets,
                 std::vector<PairFit> pairs) {
  RigStart start;
  start.views = {0, 1, 2};
  start.lag_frames = {0, 0, 0};
  start.tracklets = std::move(tracklets);
  start.pairs = std::move(pairs);
  return start;
}

// Number of detections of each person over all frames.
std::vector<int> DetectionsOfPeople(const RigStart& start) {
  std::vector<int> counts;
  for (const FrozenPerson& person : PeopleOf(Numbered(10), start).people) {
    int& count = counts.emplace_back(0);
    for (const FrozenFrame& frame : person.frames) {
      count += static_cast<int>(frame.detections.size());
    }
  }
  return counts;
}

// The second joined view is the recording's third and has a lag of two frames:
// its frames 1 .. 9 correspond to frames -1 .. 7, of which negative ones do not
// exist.
TEST(PeopleOfRig, FramesAreRealignedAndViewsRenumbered) {
  RigStart start;
  start.views = {0, 2};
  start.lag_frames = {0, 2};
  start.tracklets = {TrackletAt(0, 0, 10, 0), TrackletAt(2, 1, 10, 1)};
  start.tracklets[0].detections[4] = -1;
  start.pairs = {MatchedPair(0, 2, {{0, 1, 0.9}}, 2)};
  const FrozenMatches matches = PeopleOf(Numbered(10), start);
  ASSERT_EQ(matches.people.size(), 1u);
  const auto& frames = matches.people[0].frames;
  ASSERT_EQ(frames.size(), 10u);
  for (int k = 0; k < 10; ++k) {
    EXPECT_EQ(frames[k].frame, 100 + k);
    EXPECT_EQ(frames[k].time, FrameClock(kMovingRateHz).TimeOf(100 + k));
    EXPECT_TRUE(frames[k].written);
    std::vector<std::pair<int, int>> expected;
    if (k != 4) expected.emplace_back(0, 10 * k);
    if (k < 8) expected.emplace_back(1, 2000 + 10 * (k + 2) + 1);
    ASSERT_EQ(frames[k].detections.size(), expected.size()) << k;
    for (size_t i = 0; i < expected.size(); ++i) {
      EXPECT_EQ(frames[k].detections[i].view_idx, expected[i].first);
      EXPECT_EQ(frames[k].detections[i].detection_idx, expected[i].second);
    }
  }
}

TEST(PeopleOfRig, PeopleInASingleViewAreOmitted) {
  EXPECT_THAT(DetectionsOfPeople(StartOf({}, {})), IsEmpty());
  EXPECT_THAT(DetectionsOfPeople(
                  StartOf({TrackletAt(0, 0, 10), TrackletAt(1, 0, 10)}, {})),
              IsEmpty());
}

// Views that are not joined contribute nothing, although pairs match them.
TEST(PeopleOfRig, UnjoinedViewsAreOmitted) {
  RigStart start = StartOf(
      {TrackletAt(0, 0, 10), TrackletAt(1, 0, 10), TrackletAt(2, 0, 10)},
      {MatchedPair(0, 1, {{0, 1, 0.9}}), MatchedPair(1, 2, {{1, 2, 0.9}})});
  EXPECT_THAT(DetectionsOfPeople(start), ElementsAre(30));
  start.views = {0, 1};
  start.lag_frames = {0, 0};
  EXPECT_THAT(DetectionsOfPeople(start), ElementsAre(20));
}

// Of two overlapping tracklets of one view only the better match is the
// person's, in any order of the matches; of two consecutive tracklets both are.
TEST(PeopleOfRig, PersonHasOneTrackletPerViewAtATime) {
  for (const bool sure_first : {false, true}) {
    std::vector<TrackletMatch> matches = {{0, 1, 0.5}, {0, 2, 0.6}};
    if (sure_first) std::swap(matches[0], matches[1]);
    const auto kept = [&](const ViewTracklet& one, const ViewTracklet& other) {
      return DetectionsOfPeople(StartOf({TrackletAt(0, 0, 10), one, other},
                                        {MatchedPair(0, 1, matches)}));
    };
    // Ten frames of the first view and the six of the second tracklet.
    EXPECT_THAT(kept(TrackletAt(1, 0, 5), TrackletAt(1, 4, 10, 1)),
                ElementsAre(16));
    EXPECT_THAT(kept(TrackletAt(1, 0, 4), TrackletAt(1, 4, 10, 1)),
                ElementsAre(20));
  }
}

// Matches are used from the best to the worst. The last would, through a third
// view, merge two people who are in the first view at the same time.
TEST(PeopleOfRig, SetsThatOverlapInAViewAreNotMerged) {
  const std::vector<ViewTracklet> tracklets = {
      TrackletAt(0, 0, 10, 0), TrackletAt(1, 0, 10, 0), TrackletAt(2, 0, 10, 0),
      TrackletAt(0, 0, 10, 1), TrackletAt(1, 0, 10, 1)};
  std::vector<PairFit> pairs = {MatchedPair(0, 1, {{0, 1, 0.9}, {3, 4, 0.8}}),
                                MatchedPair(1, 2, {{4, 2, 0.6}, {1, 2, 0.7}})};
  for (int turn = 0; turn < 2; ++turn) {
    EXPECT_THAT(DetectionsOfPeople(StartOf(tracklets, pairs)),
                ElementsAre(30, 20));
    std::swap(pairs[0], pairs[1]);
  }
}

// Matches of a pair whose lag differs from the rig's by two frames are used;
// with three they are not.
TEST(PeopleOfRig, PairsWhoseLagDiffersByThreeFramesAreIgnored) {
  for (const int lag : {-3, -2, 2, 3}) {
    const RigStart start = StartOf({TrackletAt(0, 0, 10), TrackletAt(1, 0, 10)},
                                   {MatchedPair(0, 1, {{0, 1, 0.9}}, lag)});
    EXPECT_EQ(PeopleOf(Numbered(10), start).people.size(),
              std::abs(lag) == 2 ? 1u : 0u)
        << lag;
  }
}

}  // namespace
}  // namespace kinegraph
