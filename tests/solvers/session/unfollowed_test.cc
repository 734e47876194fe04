#include "solvers/session/unfollowed.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "core/skeleton/skeleton.h"
#include "tests/support/rig.h"

namespace kinegraph {
namespace {

constexpr int kFrames = 250;  // 10 s

// Two people and three cameras. The first person is tracked throughout, the
// second in the last `followed` frames; view 1 alone detects the second, in the
// frames for which `is_seen` is true. `clock`: times in frames, by frame.
std::vector<UnfollowedPerson> Often(const std::function<bool(int)>& is_seen,
                                    int followed,
                                    const std::function<int(int)>& clock) {
  const CameraRig cameras = testing::RingOfCameras(3);
  UnfollowedPeople people(cameras, MapByName(Coco17(), Coco17()), 5);
  const Pose3d first = testing::StandingPerson(-1.0, 0.0);
  const Pose3d second = testing::StandingPerson(1.0, 0.0);
  for (int f = 0; f < kFrames; ++f) {
    DetectionFrame frame = testing::FrameSeenBy(cameras, f, {first, second});
    frame.time = FrameClock(25.0).TimeOf(clock(f));
    for (size_t v = 0; v < cameras.size(); ++v) {
      if (v != 1 || !is_seen(f)) frame.views[v].detections.pop_back();
    }
    TrackFrame tracked;
    tracked.people.resize(1);
    tracked.people[0].joints = first;
    if (f >= kFrames - followed) {
      tracked.people.emplace_back();
      tracked.people[1].joints = second;
    }
    people.See(frame, tracked);
  }
  return people.Often();
}

// The second person is seen in the first `seen` frames. The clock begins to run
// after `stopped` frames.
std::vector<UnfollowedPerson> Often(int seen, int followed, int stopped = 0) {
  return Often([=](int f) { return f < seen; }, followed,
               [=](int f) { return std::max(0, f - stopped); });
}

TEST(Unfollowed, UntrackedPersonIsReportedWithViewAndShare) {
  const std::vector<UnfollowedPerson> often = Often(150, 0);
  ASSERT_EQ(often.size(), 1u);
  EXPECT_EQ(often[0].view, 1u);
  EXPECT_DOUBLE_EQ(often[0].share, 0.6);
  EXPECT_EQ(often[0].first_frame, 0);
  EXPECT_EQ(often[0].last_frame, 149);
}

TEST(Unfollowed, TrackedPersonWithoutMatchesIsNotReported) {
  EXPECT_TRUE(Often(kFrames, kFrames).empty());
}

TEST(Unfollowed, AStoppedClockDoesNotDivideAPerson) {
  const std::vector<UnfollowedPerson> often = Often(kFrames, 0, 100);
  ASSERT_EQ(often.size(), 1u);
  EXPECT_DOUBLE_EQ(often[0].share, 1.0);
}

// The clock restarts ten frames before the end, so that its last time is hardly
// after its first.
TEST(Unfollowed, AClockThatRestartsDoesNotShortenDurations) {
  const auto often = Often([](int) { return true; }, 0,
                           [](int f) { return f < 240 ? f : f - 240; });
  ASSERT_EQ(often.size(), 1u);
  EXPECT_DOUBLE_EQ(often[0].share, 1.0);
}

// Two people at one place, for 2 s each, with 1.2 s in between. Neither is seen
// long enough to be reported. The clock restarts when the first one disappears.
TEST(Unfollowed, APersonEndsAlthoughTheClockRestarts) {
  const auto is_seen = [](int f) { return f < 50 || (f >= 80 && f < 130); };
  EXPECT_TRUE(
      Often(is_seen, 0, [](int f) { return f < 50 ? f : f - 50; }).empty());
}

// 49 of 250 frames are less than a fifth, and 1.96 s are less than 3 s.
TEST(Unfollowed, RarelySeenPersonIsNotReported) {
  EXPECT_TRUE(Often(49, 0).empty());
}

}  // namespace
}  // namespace kinegraph
