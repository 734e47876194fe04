#include "core/evaluation/motion.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.h"
#include "tests/core/evaluation/people.h"

namespace kinegraph {
namespace {

using testing::Frame;
using testing::Moved;
using testing::Observed;
using testing::Person;
using testing::StandingTum14;
using testing::Tracks;

TEST(MotionTest, UniformMotionHasNoAcceleration) {
  std::vector<TrackFrame> frames;
  for (int k = 0; k < 5; ++k) {
    frames.push_back(Frame(k, {Person(0, StandingTum14(0.25 * k))}));
  }
  const MotionResult result = EvaluateMotion(Tracks(frames), 25.0);
  EXPECT_EQ(result.acceleration_m_s2, 0.0);
  EXPECT_EQ(result.acceleration_count, 3 * 12);
  EXPECT_EQ(result.bone_length_spread_m, 0.0);
  EXPECT_EQ(result.bone_count, 12);
  MotionOptions all;
  all.scope = MotionScope::kAll;
  EXPECT_EQ(EvaluateMotion(Tracks(frames), 25.0, all).acceleration_count,
            3 * 14);
  all.frames = {{0, 3}};
  EXPECT_EQ(EvaluateMotion(Tracks(frames), 25.0, all).acceleration_count, 14);
}

TEST(MotionTest, ConstantAccelerationIsFound) {
  std::vector<TrackFrame> frames;
  for (int k = 0; k < 5; ++k) {  // x = a t^2 / 2 with a = 2 m/s^2, t = k / 4 s
    frames.push_back(Frame(k, {Person(0, StandingTum14(k * k / 16.0))}));
  }
  EXPECT_DOUBLE_EQ(EvaluateMotion(Tracks(frames), 4.0).acceleration_m_s2, 2.0);
}

TEST(MotionTest, NeedsThreeConsecutiveObservedFramesOfOnePerson) {
  Pose3d inferred = StandingTum14(9.0);
  for (Joint3d& joint : inferred) joint.status = JointStatus::kInferred;
  const MotionResult result = EvaluateMotion(
      Tracks({Frame(0, {Person(0, StandingTum14())}),
              Frame(1, {Person(0, StandingTum14())}),
              Frame(3, {Person(0, StandingTum14())}),  // a gap
              Frame(4, {Person(0, inferred)}),         // not observed
              Frame(5, {Person(1, StandingTum14())}),  // another person
              Frame(6, {Person(1, StandingTum14())})}),
      25.0);
  EXPECT_EQ(result.acceleration_count, 0);
  EXPECT_TRUE(std::isnan(result.acceleration_m_s2));
  EXPECT_TRUE(std::isnan(result.acceleration_interval.low));
}

TEST(MotionTest, BoneSpreadIsTheMeanOfDeviations) {
  const Skeleton stick("stick", {"a", "b", "c"}, {{0, 1}, {1, 2}});
  // Bone a-b: 1 and 2 m, deviation 0.5; bone b-c: always 1 m. The third frame
  // lacks a; the second person has one frame only.
  MotionOptions options;
  options.scope = MotionScope::kAll;
  const MotionResult result = EvaluateMotion(
      Tracks({Frame(0, {Person(0, {Observed(0, 0, 0), Observed(1, 0, 0),
                                   Observed(2, 0, 0)})}),
              Frame(1, {Person(0, {Observed(0, 0, 0), Observed(2, 0, 0),
                                   Observed(3, 0, 0)})}),
              Frame(2, {Person(0, {Joint3d{}, Observed(2, 0, 0),
                                   Observed(3, 0, 0)}),
                        Person(1, {Observed(0, 0, 0), Observed(7, 0, 0),
                                   Observed(2, 0, 0)})})},
             stick),
      25.0, options);
  EXPECT_EQ(result.bone_count, 2);
  EXPECT_DOUBLE_EQ(result.bone_length_spread_m, 0.25);
}

TEST(MotionTest, WantsAFrameRate) {
  EXPECT_THROW(EvaluateMotion(Tracks({}), 0.0), OptionError);
}

TEST(CoverageTest, CountsTruePeopleWithAPoseNearby) {
  const TrackSequence truth = Tracks(
      {Frame(0, {Person(0, StandingTum14()), Person(1, StandingTum14(4.0))}),
       Frame(1, {Person(0, StandingTum14())})});
  const TrackSequence tracks =
      Tracks({Frame(0, {Person(7, StandingTum14(0.5)),  // exactly the gate
                        Person(8, StandingTum14(4.75))})});
  const Share covered = EvaluateCoverage(truth, tracks);
  EXPECT_EQ(covered.count, 1);
  EXPECT_EQ(covered.total, 3);
  EXPECT_EQ(EvaluateCoverage(truth, tracks, {{1, 2}}).total, 1);
}

}  // namespace
}  // namespace kinegraph
