// Tests the clock search on exact detections. For noisy scenes, see
// readings_test.cc.
#include "solvers/scene/clock_search.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <utility>
#include <vector>

#include "solvers/cameras/camera_change.h"
#include "tests/support/moving_people.h"
#include "tests/support/rig.h"

namespace kinegraph {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr int kClockFrames = 120;
constexpr int kMostLag = 20;

DetectionSequence Movers(const CameraRig& cameras) {
  return testing::SeenBy(cameras, kClockFrames, [](int frame) {
    return std::vector<Pose3d>{testing::MovingPerson(0, frame),
                               testing::MovingPerson(1, frame)};
  });
}

ClockSearch ClocksOf(const CameraRig& cameras, const DetectionSequence& seen,
                     int most = kMostLag) {
  return SearchClocks(cameras, IdealPeople(seen, cameras), most);
}

// ---- Missing frames ----

TEST(OnGrid, FillsGapsAndShortensLongOnes) {
  DetectionSequence seen;
  for (const int64_t number :
       {0, 5, 10, 20, 30, 530, 535, 541, 546, 551, 556, 561, 566}) {
    DetectionFrame frame;
    frame.frame = number;
    frame.time = FromSeconds(0.04 * static_cast<double>(number));
    frame.views.resize(2);
    seen.frames.push_back(frame);
  }
  ASSERT_EQ(UsualStep(seen.frames), 5);
  std::vector<int64_t> numbers;
  for (const DetectionFrame& frame : OnGrid(seen, 5, 2).frames) {
    numbers.push_back(frame.frame);
    EXPECT_NEAR(ToSeconds(frame.time), 0.04 * static_cast<double>(frame.frame),
                1e-6);
    EXPECT_EQ(frame.views.size(), 2u);
  }
  EXPECT_THAT(numbers, ElementsAre(0, 5, 10, 15, 20, 25, 30, 35, 40, 520, 525,
                                   530, 535, 541, 546, 551, 556, 561, 566));
  seen.frames.resize(2);
  seen.frames.push_back(seen.frames.back());
  seen.frames.back().frame = 7;
  EXPECT_EQ(UsualStep(seen.frames), 1) << "steps of 5 and 2";
}

// ---- Lags ----

// Exact joints agree at a single lag only.
TEST(ClockSearchOfExactPeople, LagsAreExact) {
  const CameraRig cameras = testing::RingOfCameras(4);
  for (const std::vector<int>& lags :
       {std::vector<int>{0, 7, -5, 0}, std::vector<int>{0, 0, 0, 12},
        std::vector<int>{0, 6, 6, 6}}) {
    // Frame k + lag must show time k.
    std::vector<int> back;
    for (const int lag : lags) back.push_back(-lag);
    const ClockSearch search =
        ClocksOf(cameras, Realigned(Movers(cameras), back));
    EXPECT_TRUE(search.found());
    EXPECT_EQ(search.lag_frames, lags);
    // A score is the mean over a few hundred matched people of 1 minus a
    // relative distance from the epipolar lines, here only rounding errors.
    EXPECT_NEAR(search.all.after.score(), 1.0, 1e-9);
    EXPECT_NEAR(search.moved.after.score(), 1.0, 1e-9);
    EXPECT_LT(search.all.before.score(), search.all.after.score());
    EXPECT_LE(search.moved.before.score(), search.all.before.score());
  }
}

// Three of the six pairs of four views contain the late view. Every fourth of
// the 120 frames is examined, 30 in all, with two people each. The first eight
// frames of the late view are empty; two of them are among the examined frames.
TEST(ClockSearchOfExactPeople, MovedCoversThePairsWithDifferentLags) {
  const CameraRig cameras = testing::RingOfCameras(4);
  const ClockSearch search =
      ClocksOf(cameras, Realigned(Movers(cameras), {0, 0, -8, 0}));
  EXPECT_THAT(search.lag_frames, ElementsAre(0, 0, 8, 0));
  EXPECT_EQ(search.moved.before.possible, 3.0 * 28.0 * 2.0);
  EXPECT_EQ(search.all.before.possible, 3.0 * 28.0 * 2.0 + 3.0 * 30.0 * 2.0);
}

// Lags are relative to the first view in any order of views.
TEST(ClockSearchOfExactPeople, InvariantToTheOrderOfViews) {
  CameraRig cameras = testing::RingOfCameras(3);
  DetectionSequence seen = Realigned(Movers(cameras), {0, -7, 5});
  EXPECT_THAT(ClocksOf(cameras, seen).lag_frames, ElementsAre(0, 7, -5));
  std::swap(cameras[0], cameras[1]);
  for (DetectionFrame& frame : seen.frames) {
    std::swap(frame.views[0], frame.views[1]);
    for (ViewDetections& view : frame.views) {
      std::reverse(view.detections.begin(), view.detections.end());
    }
  }
  EXPECT_THAT(ClocksOf(cameras, seen).lag_frames, ElementsAre(0, -7, -12));
}

TEST(ClockSearchOfExactPeople, InvariantToTheWorldFrame) {
  CameraRig cameras = testing::RingOfCameras(3);
  const DetectionSequence seen = Realigned(Movers(cameras), {0, -7, 5});
  const Eigen::Matrix3d turn = ExpRotation({0.3, -0.8, 1.1});
  cameras = Edited(cameras, [&](CameraParameters* camera) {
    camera->R = camera->R * turn.transpose();
    camera->t -= camera->R * Eigen::Vector3d(2.0, 3.0, -1.0);
  });
  EXPECT_THAT(ClocksOf(cameras, seen).lag_frames, ElementsAre(0, 7, -5));
}

TEST(ClockSearchOfExactPeople, SynchronisedViewsHaveNoLags) {
  const CameraRig cameras = testing::RingOfCameras(3);
  const ClockSearch search = ClocksOf(cameras, Movers(cameras));
  EXPECT_FALSE(search.found());
  EXPECT_THAT(search.lag_frames, ElementsAre(0, 0, 0));
  EXPECT_EQ(search.moved.before.possible, 0.0);
}

// People at rest agree equally well at any lag.
TEST(ClockSearchOfExactPeople, PeopleAtRestHaveNoLags) {
  const CameraRig cameras = testing::RingOfCameras(3);
  const DetectionSequence seen =
      testing::SeenBy(cameras, kClockFrames, [](int) {
        return std::vector<Pose3d>{testing::StandingPerson(0.0, 0.0)};
      });
  EXPECT_FALSE(ClocksOf(cameras, Realigned(seen, {0, -7, 5})).found());
}

// A lag of 9 is found with a maximum of 9, but not with 5, or in 24 frames, a
// third of which is 8.
TEST(ClockSearchOfExactPeople, LagsBeyondTheReachAreNotFound) {
  const CameraRig cameras = testing::RingOfCameras(2);
  DetectionSequence seen = Realigned(Movers(cameras), {0, -9});
  EXPECT_THAT(ClocksOf(cameras, seen, 9).lag_frames, ElementsAre(0, 9));
  const auto nearer = ClocksOf(cameras, seen, 5).lag_frames;
  EXPECT_LE(std::abs(nearer[1]), 5);
  seen.frames.resize(24);
  EXPECT_LE(std::abs(ClocksOf(cameras, seen, 20).lag_frames[1]), 8);
}

TEST(ClockSearchOfExactPeople, NoLagsWithoutViewPairsOrPeople) {
  const CameraRig none;
  EXPECT_THAT(SearchClocks(none, {}, kMostLag).lag_frames, IsEmpty());
  const CameraRig one = testing::RingOfCameras(1);
  EXPECT_THAT(ClocksOf(one, Movers(one)).lag_frames, ElementsAre(0));
  const CameraRig cameras = testing::RingOfCameras(3);
  DetectionSequence nobody = Movers(cameras);
  for (DetectionFrame& frame : nobody.frames) {
    for (ViewDetections& view : frame.views) view.detections.clear();
  }
  const ClockSearch search = ClocksOf(cameras, nobody);
  EXPECT_FALSE(search.found());
  EXPECT_EQ(search.lag_frames.size(), 3u);
  EXPECT_THAT(search.lag_frames, Each(0));
  nobody.frames.clear();
  EXPECT_FALSE(ClocksOf(cameras, nobody).found());
}

// The lag of the empty view is unknown.
TEST(ClockSearchOfExactPeople, EmptyViewDoesNotAffectOtherLags) {
  const CameraRig cameras = testing::RingOfCameras(4);
  DetectionSequence seen = Realigned(Movers(cameras), {0, -7, 0, 0});
  for (DetectionFrame& frame : seen.frames) frame.views[3].detections.clear();
  const ClockSearch search = ClocksOf(cameras, seen);
  EXPECT_THAT(search.lag_frames, ElementsAre(0, 7, 0, ::testing::_));
}

}  // namespace
}  // namespace kinegraph
