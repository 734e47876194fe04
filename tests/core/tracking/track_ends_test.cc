#include "core/tracking/track_ends.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/support/rig.h"

namespace kinegraph {
namespace {

constexpr double kRate = 25.0;

TimeNs TimeOf(int64_t frame) { return FrameClock(kRate).TimeOf(frame); }

TrackFrame Frame(int64_t number, const std::vector<double>& x_m) {
  TrackFrame frame;
  frame.frame = number;
  frame.time = TimeOf(number);
  for (size_t p = 0; p < x_m.size(); ++p) {
    if (std::isnan(x_m[p])) continue;
    PersonPose& person = frame.people.emplace_back();
    person.id = TrackId(static_cast<int64_t>(p));
    person.joints = testing::StandingPerson(x_m[p], 0.0);
  }
  return frame;
}

TEST(FindRunsTest, RunsEndWhereAFrameLacksThePerson) {
  // Person 0 walks at 1 m/s but for frame 4; person 1 is there once.
  std::vector<TrackFrame> frames;
  for (int64_t f = 0; f < 10; ++f) {
    const double x_m = f == 4 ? NAN : 0.04 * static_cast<double>(f);
    frames.push_back(Frame(f, {x_m, f == 7 ? 3.0 : NAN}));
  }
  const auto runs = FindRuns(frames);
  ASSERT_EQ(runs.at(TrackId(0)).size(), 2u);
  const TrackRun& first = runs.at(TrackId(0))[0];
  EXPECT_EQ(first.first, 0);
  EXPECT_EQ(first.last, 3);
  EXPECT_NEAR(first.first_velocity_mps.x(), 1.0, 1e-9);
  EXPECT_NEAR(first.last_velocity_mps.x(), 1.0, 1e-9);
  EXPECT_EQ(runs.at(TrackId(0))[1].first, 5);
  EXPECT_EQ(runs.at(TrackId(0))[1].last, 9);
  ASSERT_EQ(runs.at(TrackId(1)).size(), 1u);
  EXPECT_EQ(runs.at(TrackId(1))[0].last_velocity_mps.norm(), 0.0);
}

TEST(EndFollowerTest, GoesOnAndFadesBothWays) {
  const Pose3d pose = testing::StandingPerson(0.0, 0.0);
  const EndFollower follower(pose, TimeOf(50), {1.0, 0.0, 0.0});
  const auto moved_m = [&](int64_t frame) {
    return follower.At(TimeOf(frame))[0].position_m.x() -
           pose[0].position_m.x();
  };
  // 0.5 s (1 - exp(-t / 0.5 s)): one frame on, and never beyond 0.5 m.
  EXPECT_NEAR(moved_m(51), 0.5 * (1.0 - std::exp(-0.08)), 1e-9);
  EXPECT_NEAR(moved_m(49), -moved_m(51), 1e-12);
  EXPECT_NEAR(moved_m(5000), 0.5, 1e-9);
}

TEST(EndFollowerTest, LearnsFromWhatViewsAgreeOn) {
  EndFollower follower(testing::StandingPerson(0.0, 0.0), TimeOf(0),
                       Eigen::Vector3d::Zero());
  for (int64_t f = 1; f <= 20; ++f) {
    follower.Agree(testing::StandingPerson(0.04 * static_cast<double>(f), 0.0),
                   TimeOf(f));
  }
  EXPECT_EQ(follower.agreed(), TimeOf(20));
  // 1 m/s within 0.7^20, faded over one frame.
  const double step_m = follower.At(TimeOf(21))[0].position_m.x() -
                        testing::StandingPerson(0.8, 0.0)[0].position_m.x();
  EXPECT_NEAR(step_m, 0.5 * (1.0 - std::exp(-0.08)), 1e-4);
}

TEST(AtOnePlaceTest, WhatIsSeenTellsAndWhatIsInferredDoesNot) {
  const Pose3d here = testing::StandingPerson(0.0, 0.0);
  Pose3d there = testing::StandingPerson(0.19, 0.0);
  EXPECT_TRUE(AtOnePlace(here, there, 0.2));
  EXPECT_TRUE(SeenAtOnePlace(here, there, 0.2));
  EXPECT_FALSE(SeenAtOnePlace(here, there, 0.18));
  for (size_t j = 0; j < 8; ++j) there[j].position_m.z() += 2.0;
  EXPECT_TRUE(SeenAtOnePlace(here, there, 0.2));  // nine of 17
  there[8].position_m.z() += 2.0;
  EXPECT_FALSE(SeenAtOnePlace(here, there, 0.2));
  there = testing::StandingPerson(0.19, 0.0);
  for (size_t j = 3; j < there.size(); ++j) {
    there[j].status = JointStatus::kInferred;
    there[j].position_m.x() += 1.0;
  }
  EXPECT_FALSE(AtOnePlace(here, there, 0.2));
  EXPECT_TRUE(SeenAtOnePlace(here, there, 0.2));
  EXPECT_TRUE(SeenAtOnePlace(there, here, 0.2));
  there[2].status = JointStatus::kInferred;  // two joints are no body
  EXPECT_FALSE(SeenAtOnePlace(here, there, 0.2));
}

TEST(IsTakenTest, NearerThanPeopleStand) {
  const TrackFrame frame = Frame(0, {0.0});
  const std::vector<PersonPose>& people = frame.people;
  EXPECT_TRUE(IsTaken(testing::StandingPerson(0.29, 0.0), people));
  EXPECT_FALSE(IsTaken(testing::StandingPerson(0.31, 0.0), people));
}

}  // namespace
}  // namespace kinegraph
