// Evidence that two tracks show one person: bones (bones.h) and motion
// (motion.h).
#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "core/identity/bones.h"
#include "core/identity/motion.h"
#include "core/identity/tracklet.h"
#include "tests/core/identity/crowd.h"

namespace kinegraph {
namespace {

using testing::CrowdMaker;

TEST(BoneModelTest, DistinguishesOneBodyFromTwo) {
  CrowdMaker crowd(500);
  crowd.Add({0, 0, 240, {0.0, 0.0}, {0.0, 0.0}, 1.0});
  crowd.Add({1, 250, 499, {0.0, 0.0}, {0.0, 0.0}, 1.0});
  crowd.Add({2, 250, 499, {2.0, 0.0}, {0.0, 0.0}, 1.12});
  const std::vector<Tracklet> people =
      CollectTracklets(crowd.frames(), Coco17());
  ASSERT_EQ(people.size(), 3u);
  BoneModel model(Coco17());
  std::vector<BoneSamples> samples;
  for (const Tracklet& person : people)
    samples.push_back(model.Measure(person));
  model.Learn(samples);
  EXPECT_GT(model.LogRatio(samples[0], samples[1]), 3.0);
  EXPECT_LT(model.LogRatio(samples[0], samples[2]), -10.0);
  EXPECT_DOUBLE_EQ(model.LogRatio(samples[0], samples[2]),
                   model.LogRatio(samples[2], samples[0]));
  EXPECT_LT(model.MeanDifference(samples[0], samples[1]), 0.005);
  // The bones are 0.22 to 0.51 m long, on average 0.37 m; those of the third
  // track are 12 % (0.044 m) longer.
  EXPECT_NEAR(model.MeanDifference(samples[0], samples[2]), 0.04, 0.015);
}

// The tops and bottoms of people's boxes: their heights are evidence.
TEST(BoneModelTest, DistinguishesBoxesByHeight) {
  CrowdMaker crowd(500);
  crowd.Add({0, 0, 240, {0.0, 0.0}, {0.0, 0.0}, 1.0});
  crowd.Add({1, 250, 499, {0.0, 0.0}, {0.0, 0.0}, 1.0});
  crowd.Add({2, 250, 499, {2.0, 0.0}, {0.0, 0.0}, 1.12});
  const Skeleton box("box", {"top", "bottom"}, {{0, 1}});
  const auto nose = static_cast<size_t>(Coco17().IndexOf("nose"));
  const auto ankle = static_cast<size_t>(Coco17().IndexOf("l_ankle"));
  std::vector<TrackFrame> frames = crowd.frames();
  for (TrackFrame& frame : frames) {
    for (PersonPose& person : frame.people) {
      person.joints = {person.joints[nose], person.joints[ankle]};
      person.inlier_views.resize(2);
    }
  }
  const std::vector<Tracklet> people = CollectTracklets(frames, box);
  BoneModel model(box);
  std::vector<BoneSamples> samples;
  for (const Tracklet& person : people)
    samples.push_back(model.Measure(person));
  model.Learn(samples);
  EXPECT_GT(model.LogRatio(samples[0], samples[1]), 1.0);
  EXPECT_LT(model.LogRatio(samples[0], samples[2]), -2.0);
}

// The log ratio of two tracks of one body. The second lasts a second, and its
// bones are measured 4 % longer; joints state a standard deviation of `sigma_m`
// in each coordinate.
double RatioOfShortPiece(double sigma_m) {
  CrowdMaker crowd(400);
  crowd.Add({0, 0, 299, {0.0, 0.0}, {0.0, 0.0}, 1.0});
  crowd.Add({1, 310, 334, {0.0, 0.0}, {0.0, 0.0}, 1.04});
  std::vector<TrackFrame> frames = crowd.frames();
  for (TrackFrame& frame : frames) {
    for (PersonPose& person : frame.people) {
      person.covariances.assign(
          person.joints.size(),
          Eigen::Matrix3d(sigma_m * sigma_m * Eigen::Matrix3d::Identity()));
    }
  }
  const std::vector<Tracklet> people = CollectTracklets(frames, Coco17());
  BoneModel model(Coco17());
  const BoneSamples one = model.Measure(people[0]);
  const BoneSamples other = model.Measure(people[1]);
  model.Learn({one, other});
  return model.LogRatio(one, other);
}

TEST(BoneModelTest, ShortPieceIsAsUncertainAsStated) {
  // A length of 0.5 m is off by 20 mm. With joints accurate to 5 mm, whose
  // errors last for 0.35 s (kErrorLasts in bones.cc), one second would
  // determine it to 5 mm * sqrt(2) * sqrt(0.35 / 1) = 4 mm, but no better than
  // 1 %, 5 mm, is assumed; the long track determines it to 2 mm. The floors of
  // the two tracks, 5 mm each, add 7 mm: 20 mm is 2.3 sigmas. With joints
  // accurate to 20 mm the tracks determine it to 17 mm and 6 mm: 1.0 sigma.
  const double sure = RatioOfShortPiece(0.005);
  const double unsure = RatioOfShortPiece(0.02);
  EXPECT_LT(sure, -3.0);
  EXPECT_GT(unsure, sure + 2.0);
}

TEST(BoneModelTest, UnmeasuredBodiesGiveNoEvidence) {
  CrowdMaker crowd(100);
  crowd.Add({0, 0, 99, {0.0, 0.0}, {0.0, 0.0}, 1.0});
  // Two frames, fewer than a piece needs.
  crowd.Add({1, 50, 51, {2.0, 0.0}, {0.0, 0.0}, 1.0});
  const std::vector<Tracklet> people =
      CollectTracklets(crowd.frames(), Coco17());
  ASSERT_EQ(people.size(), 2u);
  const BoneModel model(Coco17());
  const BoneSamples measured = model.Measure(people[0]);
  for (const std::vector<BoneSamples::Piece>& bone : measured.of_bone) {
    EXPECT_FALSE(bone.empty());
  }
  for (const BoneSamples& unmeasured :
       {BoneSamples(), model.Measure(people[1])}) {
    EXPECT_EQ(model.LogRatio(measured, unmeasured), 0.0);
    EXPECT_EQ(model.MeanDifference(measured, unmeasured), 0.0);
  }
}

TEST(BoneModelTest, InferredJointsDoNotCount) {
  CrowdMaker crowd(100);
  crowd.Add({0, 0, 99, {0.0, 0.0}, {0.0, 0.0}, 1.0});
  std::vector<TrackFrame> frames = crowd.frames();
  for (TrackFrame& frame : frames) {
    for (Joint3d& joint : frame.people[0].joints) {
      joint.status = JointStatus::kInferred;
    }
  }
  const BoneModel model(Coco17());
  const BoneSamples samples =
      model.Measure(CollectTracklets(frames, Coco17())[0]);
  for (const std::vector<BoneSamples::Piece>& bone : samples.of_bone) {
    EXPECT_TRUE(bone.empty());
  }
}

// Motion in an occupied space of 10 m x 2.5 m.
IdentityMotion Box() {
  std::vector<Tracklet> corners(1);  // half a metre inside the space
  for (const double x_m : {-4.5, 4.5}) {
    for (const double y_m : {-0.75, 0.75}) {
      corners[0].frames.emplace_back().centre_m = {x_m, y_m, 1.0};
    }
  }
  return IdentityMotion(corners);
}

MotionState State(double time_s, double x_m, double vx_mps) {
  return {FromSeconds(time_s), {x_m, 0.0, 1.0}, {vx_mps, 0.0, 0.0}};
}

TEST(MotionModelTest, ContinuedWalkIsLikely) {
  const IdentityMotion model = Box();
  const MotionState from = State(0.0, 0.0, 1.0);
  const double walks_on = model.LogRatio(from, State(0.4, 0.4, 1.0), 0.04);
  const double turns_back = model.LogRatio(from, State(0.4, -0.4, -1.0), 0.04);
  EXPECT_GT(walks_on, 3.0);
  EXPECT_GT(walks_on, turns_back + 2.0);
}

TEST(MotionModelTest, StandingPeopleAreNotExpectedFarAway) {
  const IdentityMotion model = Box();
  const auto ratio = [&](double speed_mps, double x_m) {
    return model.LogRatio(State(0.0, 0.0, speed_mps), State(0.6, x_m, 0.0),
                          0.04);
  };
  // 0.8 m away at rest after 0.6 s: plausible for a walker who stopped, hardly
  // for a standing person.
  EXPECT_GT(ratio(1.2, 0.8), ratio(0.0, 0.8) + 1.0);
  // It is more certain that a standing person stays than that a walker stops
  // there.
  EXPECT_GT(ratio(0.0, 0.0), ratio(1.2, 0.8) + 1.0);
}

TEST(MotionModelTest, CrossingARoomAtOnceIsUnlikely) {
  const IdentityMotion model = Box();
  const MotionState from = State(0.0, 0.0, 0.0);
  EXPECT_LT(model.LogRatio(from, State(0.2, 4.0, 0.0), 0.04), -8.0);
  // After half a minute the same distance is hardly any evidence: a factor of
  // about two at most.
  EXPECT_NEAR(model.LogRatio(from, State(30.0, 4.0, 0.0), 0.04), 0.0, 0.8);
}

TEST(MotionModelTest, AStateThatIsNotLaterCountsAsTheNextFrame) {
  const IdentityMotion model = Box();
  const MotionState from = State(1.0, 0.0, 0.0);
  EXPECT_EQ(model.LogRatio(from, State(0.8, 0.0, 0.0), 0.04),
            model.LogRatio(from, State(1.04, 0.0, 0.0), 0.04));
}

TEST(MotionModelTest, StandingPeopleKeepHeading) {
  const IdentityMotion model = Box();
  const auto ratio = [&](double gap_s, double turned_rad, double vx_mps) {
    MotionState from = State(0.0, 0.0, 0.0);
    MotionState to = State(gap_s, 0.0, vx_mps);
    from.across_m = {0.0, 0.4, 0.0};
    to.across_m = {-0.4 * std::sin(turned_rad), 0.4 * std::cos(turned_rad),
                   0.0};
    return model.LogRatio(from, to, 0.04);
  };
  const double unknown =
      model.LogRatio(State(0.0, 0.0, 0.0), State(1.0, 0.0, 0.0), 0.04);
  EXPECT_GT(ratio(1.0, 0.1, 0.0), unknown + 1.0);
  // Facing the other way is weaker evidence, because people turn round.
  EXPECT_LT(ratio(1.0, 3.0, 0.0), unknown - 0.4);
  EXPECT_GT(ratio(1.0, 3.0, 0.0), unknown - 1.5);
  // Turns to the left and to the right are equivalent.
  EXPECT_NEAR(ratio(1.0, 0.5, 0.0), ratio(1.0, -0.5, 0.0), 1e-9);
  // After minutes, and for striding people, the heading is hardly any evidence.
  EXPECT_NEAR(ratio(120.0, 0.1, 0.0), ratio(120.0, 3.0, 0.0), 0.05);
  EXPECT_LT(ratio(1.0, 0.1, 2.0) - ratio(1.0, 3.0, 2.0),
            0.25 * (ratio(1.0, 0.1, 0.0) - ratio(1.0, 3.0, 0.0)));
}

TEST(MotionModelTest, PeopleStayInTheSpace) {
  // After some seconds the person may be anywhere in the space; probability
  // outside it must not reduce that inside.
  const IdentityMotion model = Box();
  const double ratio =
      model.LogRatio(State(0.0, 0.0, 0.0), State(4.0, 1.0, 0.0), 0.04);
  EXPECT_GT(ratio, 0.0);
}

TEST(MotionStateTest, ReadsPositionAndVelocityAtBothEnds) {
  CrowdMaker crowd(100);
  crowd.Add({0, 0, 99, {1.0, 2.0}, {1.0, -0.5}, 1.0}, 0.0);
  const Tracklet walk = CollectTracklets(crowd.frames(), Coco17())[0];
  const MotionState begin = StateAtBegin(walk);
  const MotionState end = StateAtEnd(walk);
  EXPECT_EQ(begin.time, 0);
  EXPECT_EQ(end.time, FrameClock(25.0).TimeOf(99));
  // A velocity fitted over 0.3 s is shrunk towards zero, here by 7 % (FitState
  // in tracklet.cc).
  EXPECT_NEAR(begin.velocity_mps.x(), 1.0, 0.15);
  EXPECT_NEAR(end.velocity_mps.y(), -0.5, 0.08);
  EXPECT_NEAR(begin.position_m.x(), 1.0, 0.03);
  EXPECT_NEAR(end.position_m.x(), 1.0 + 99.0 / 25.0, 0.03);
}

TEST(MotionStateTest, StateUpToATimeIgnoresLaterFrames) {
  CrowdMaker crowd(100);
  crowd.Add({0, 0, 99, {1.0, 2.0}, {1.0, -0.5}, 1.0}, 0.0);
  const Tracklet walk = CollectTracklets(crowd.frames(), Coco17())[0];
  const FrameClock clock(25.0);
  const MotionState state = StateUpTo(walk, clock.TimeOf(50));
  EXPECT_EQ(state.time, clock.TimeOf(50));
  EXPECT_NEAR(state.position_m.x(), 1.0 + 50.0 / 25.0, 0.03);
  EXPECT_EQ(StateUpTo(walk, clock.TimeOf(200)).time, clock.TimeOf(99));
}

// Track 0 stands next to another person, who leaves; then track 0 is unobserved
// for 0.4 s and is found elsewhere. All of this is one contact.
TEST(ContactsTest, UnobservedHopIsRecordedAndCut) {
  CrowdMaker crowd(300);
  crowd.Add({0, 0, 139, {0.0, 0.0}, {0.0, 0.0}, 1.0})
      .Add({0, 140, 149, {0.0, 0.0}, {3.0, 0.0}, 1.0, false})
      .Add({0, 150, 299, {1.2, 0.0}, {0.0, 0.0}, 1.0})
      .Add({1, 0, 125, {0.0, 0.6}, {0.0, 0.0}, 1.0});
  const std::vector<TrackFrame> frames = crowd.frames();
  const Pieces pieces = CutAtContacts(CollectTracklets(frames, Coco17()));
  ASSERT_EQ(pieces.tracklets.size(), 3u);  // two of track 0, and track 1
  EXPECT_FALSE(pieces.blind[0]);
  ASSERT_EQ(pieces.hops[0].size(), 1u);
  const auto& [before, after] = pieces.hops[0][0];
  EXPECT_EQ(before.time, frames[139].time);
  EXPECT_EQ(after.time, frames[150].time);
  EXPECT_NEAR(after.position_m.x() - before.position_m.x(), 1.2, 0.03);
  EXPECT_GE(pieces.tracklets[1].first().frame, 140);
  EXPECT_LE(pieces.tracklets[1].first().frame, 150);
  // From rest to rest, 1.2 m in 0.44 s are implausible.
  EXPECT_LT(Box().LogRatio(before, after, 0.04), -3.0);
}

// At a low frame rate frames are farther apart than a gap without observations
// may be.
TEST(ContactsTest, LowFrameRatesAreNotGaps) {
  CrowdMaker crowd(100);
  crowd.Add({0, 0, 99, {0.0, 0.0}, {0.0, 0.0}, 1.0});
  std::vector<TrackFrame> frames = crowd.frames();
  for (TrackFrame& frame : frames) {
    frame.time = FrameClock(4.0).TimeOf(frame.frame);
  }
  const auto count = [&] {
    return CutAtContacts(CollectTracklets(frames, Coco17())).tracklets.size();
  };
  EXPECT_EQ(count(), 1u);
  frames[50].people[0].inlier_views.assign(17, 0);
  EXPECT_EQ(count(), 2u);
}

TEST(ContactsTest, TrackIsCutAtUnobservedFrames) {
  CrowdMaker crowd(300);
  crowd.Add({0, 0, 139, {0.0, 0.0}, {0.0, 0.0}, 1.0})
      .Add({0, 140, 149, {0.0, 0.0}, {0.0, 0.0}, 1.0, false})
      .Add({0, 150, 299, {0.0, 0.0}, {0.0, 0.0}, 1.0});
  const Pieces pieces =
      CutAtContacts(CollectTracklets(crowd.frames(), Coco17()));
  ASSERT_EQ(pieces.tracklets.size(), 2u);
  EXPECT_EQ(pieces.next, (std::vector<int>{1, -1}));
  EXPECT_TRUE(pieces.blind[0]);
  EXPECT_TRUE(pieces.hops[0].empty());
}

}  // namespace
}  // namespace kinegraph
