#include "core/evaluation/markers/gait_events.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/evaluation/people.h"

namespace kinegraph::testing {
namespace {

constexpr double kRate = 100.0;
constexpr double kPi = 3.141592653589793;

TrackSequence Feet(const std::vector<Pose3d>& poses) {
  TrackSequence tracks =
      Tracks({}, Skeleton("feet",
                          {"l_hip", "r_hip", "l_ankle", "r_ankle", "l_heel",
                           "r_heel", "l_big_toe", "r_big_toe"},
                          {}));
  for (size_t f = 0; f < poses.size(); ++f) {
    tracks.frames.push_back({static_cast<int64_t>(f),
                             FromSeconds(static_cast<double>(f) / kRate),
                             {Person(0, poses[f])}});
  }
  return tracks;
}

Pose3d Standing(double pelvis, double left, double right, double lift) {
  return {Observed(pelvis, 0.1, 1.0),       Observed(pelvis, -0.1, 1.0),
          Observed(left, 0.1, 0.1 + lift),  Observed(right, -0.1, 0.1 + lift),
          Observed(left - 0.05, 0.1, lift), Observed(right - 0.05, -0.1, lift),
          Observed(left + 0.2, 0.1, lift),  Observed(right + 0.2, -0.1, lift)};
}

// Four seconds in which the feet swing 0.3 m about the pelvis with a period of
// 1 s; the right foot lags by half a period.
std::vector<Pose3d> Walking() {
  std::vector<Pose3d> poses;
  for (int f = 0; f < 400; ++f) {
    const double t = f / kRate;
    const double swing = 0.3 * std::sin(2.0 * kPi * t);
    poses.push_back(Standing(1.2 * t, 1.2 * t + swing, 1.2 * t - swing, 0.0));
  }
  return poses;
}

// Checks the times of the events in the motion of Walking() and returns the
// number of contacts of the left foot.
int LeftContacts(const FootEvents& found) {
  EXPECT_TRUE(found.is_walk);
  int left_contacts = 0;
  for (const FootEvent& event : found.events) {
    const double phase = event.time_s - std::floor(event.time_s);
    const bool is_front = (event.foot == Foot::kLeft) == event.is_contact;
    EXPECT_NEAR(phase, is_front ? 0.25 : 0.75, 1e-3) << event.time_s;
    left_contacts += event.foot == Foot::kLeft && event.is_contact ? 1 : 0;
  }
  return left_contacts;
}

TEST(GaitEvents, WalkingEventsFollowFeetRelativeToPelvis) {
  const FootEvents found = FindFootEvents(Feet(Walking()), {0.0, 0.0, 1.0});
  EXPECT_NEAR(StrideTime(found), 1.0, 1e-3);
  EXPECT_EQ(LeftContacts(found), 4);
}

TEST(GaitEvents, WalkingEventsSurviveATurn) {
  // Four seconds forth and, after a turn on the spot, four seconds back.
  std::vector<Pose3d> poses = Walking();
  for (Pose3d pose : Walking()) {
    for (Joint3d& joint : pose) {
      joint.position_m.x() = 4.8 - joint.position_m.x();
      joint.position_m.y() *= -1.0;
    }
    poses.push_back(pose);
  }
  const FootEvents found = FindFootEvents(Feet(poses), {0.0, 0.0, 1.0});
  EXPECT_EQ(LeftContacts(found), 8);
}

TEST(GaitEvents, EdgesOfGapsAreNoEvents) {
  // Frames or feet are missing from 2.15 s to 2.6 s; a contact of the left
  // foot, at 2.25 s, lies in this gap.
  const TrackSequence walk = Feet(Walking());
  TrackSequence without_frames = walk;
  without_frames.frames.erase(without_frames.frames.begin() + 215,
                              without_frames.frames.begin() + 260);
  TrackSequence without_feet = walk;
  for (size_t f = 215; f < 260; ++f) {
    Pose3d& joints = without_feet.frames[f].people[0].joints;
    for (size_t j = 2; j < joints.size(); ++j) joints[j] = Joint3d{};
  }
  for (const TrackSequence& motion : {without_frames, without_feet}) {
    const FootEvents found = FindFootEvents(motion, {0.0, 0.0, 1.0});
    EXPECT_EQ(LeftContacts(found), 3);
    for (const FootEvent& event : found.events) {
      EXPECT_TRUE(event.time_s < 2.15 || event.time_s > 2.6) << event.time_s;
    }
  }
}

TEST(GaitEvents, JumpEventsMatchForcePlates) {
  // In the air from 1.0 to 1.4 s, on the floor before and after.
  std::vector<Pose3d> poses;
  for (int f = 0; f < 300; ++f) {
    const double t = f / kRate;
    const double u = t - 1.0;
    const double lift = u > 0.0 && u < 0.4 ? 0.5 * 9.81 * u * (0.4 - u) : 0.0;
    poses.push_back(Standing(0.0, 0.0, 0.0, lift));
  }
  const TrackSequence motion = Feet(poses);
  const FootEvents found = FindFootEvents(motion, {0.0, 0.0, 1.0});
  EXPECT_FALSE(found.is_walk);
  ASSERT_EQ(found.events.size(), 4u);
  ForcePlate plate;
  plate.centre_m = {0.0, 0.15, 0.0};
  plate.rate_hz = 1000.0;
  for (int i = 0; i < 3000; ++i) {
    plate.load_n.push_back(i > 1000 && i < 1400 ? 0.0 : 400.0);
  }
  const auto timed = CompareWithPlates({plate}, found, motion, {0.0, 0.0, 1.0});
  ASSERT_EQ(timed.size(), 2u);
  EXPECT_FALSE(timed[0].plate.is_contact);
  EXPECT_EQ(timed[0].plate.foot, Foot::kLeft);
  EXPECT_NEAR(timed[0].plate.time_s, 1.001, 1e-9);
  // Speeds are differences over two frames of 10 ms.
  EXPECT_NEAR(timed[0].found_minus_plate_s, 0.0, 0.010);
  EXPECT_NEAR(timed[1].found_minus_plate_s, 0.0, 0.010);
  // A foot with a missing ankle is not considered.
  TrackSequence gap = motion;
  const int ankle = motion.header.skeleton.IndexOf("l_ankle");
  for (TrackFrame& frame : gap.frames) {
    frame.people[0].joints[static_cast<size_t>(ankle)] = Joint3d{};
  }
  EXPECT_EQ(
      CompareWithPlates({plate}, found, gap, {0.0, 0.0, 1.0})[0].plate.foot,
      Foot::kRight);
}

}  // namespace
}  // namespace kinegraph::testing
