#include "core/evaluation/pcp.h"

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

constexpr int kAnkle = 0;
constexpr int kKnee = 1;
constexpr int kRightLowerLeg = 0;

PcpProtocol Plain() {
  PcpProtocol protocol;
  protocol.headline_actors = {};
  return protocol;
}

PcpResult Evaluate(const Pose3d& found, const PcpProtocol& protocol) {
  return EvaluatePcp(Tracks({Frame(0, {Person(0, StandingTum14())})}),
                     Tracks({Frame(0, {Person(7, found)})}), protocol);
}

TEST(PcpTest, PerfectPredictionIsAllRight) {
  const PcpResult result = Evaluate(StandingTum14(), Plain());
  EXPECT_EQ(CountParts(result, 0, PcpGroup::kTotal).count, 10);
  EXPECT_EQ(CountParts(result, 0, PcpGroup::kTotal).total, 10);
  EXPECT_EQ(CountParts(result, 0, PcpGroup::kLowerArms).total, 2);
  EXPECT_EQ(CountParts(result, 0, PcpGroup::kHead).total, 1);
  EXPECT_TRUE(result.lost.empty());
  EXPECT_EQ(MeanOfActors(result, PcpGroup::kTotal), 100.0);
}

// The lower leg is 0.5 m long: its limit is 0.25 m.
TEST(PcpTest, MeanRuleCountsTheMeanOfBothEnds) {
  Pose3d found = StandingTum14();
  found[kAnkle].position_m.y() += 0.5;  // mean 0.25, exactly the limit
  PcpProtocol protocol = Plain();
  EXPECT_TRUE(Evaluate(found, protocol).lost.empty());
  protocol.strictly_less = true;
  ASSERT_EQ(Evaluate(found, protocol).lost.size(), 1u);
  protocol.strictly_less = false;
  found[kAnkle].position_m.y() += 0x1p-20;
  EXPECT_EQ(Evaluate(found, protocol).lost.size(), 1u);
}

TEST(PcpTest, EachRuleWantsBothEndsWithin) {
  PcpProtocol protocol = Plain();
  protocol.endpoints = EndpointRule::kEach;
  Pose3d found = StandingTum14();
  found[kAnkle].position_m.y() += 0.25;  // exactly the limit
  EXPECT_TRUE(Evaluate(found, protocol).lost.empty());
  protocol.strictly_less = true;
  EXPECT_EQ(Evaluate(found, protocol).lost.size(), 1u);
  protocol.strictly_less = false;
  found[kAnkle].position_m.y() = 0.3125;  // right by the mean, not by each
  EXPECT_EQ(Evaluate(found, protocol).lost.size(), 1u);
  EXPECT_TRUE(Evaluate(found, Plain()).lost.empty());
}

TEST(PcpTest, LostPartsSayWhy) {
  const TrackSequence truth = Tracks({Frame(0, {Person(0, StandingTum14())})});
  const auto reason = [&](const std::vector<PersonPose>& found) {
    const PcpResult result =
        EvaluatePcp(truth, Tracks({Frame(0, found)}), Plain());
    EXPECT_FALSE(result.lost.empty());
    return result.lost.front().reason();
  };
  EXPECT_EQ(reason({}), LossReason::kNobody);
  EXPECT_EQ(reason({Person(0, Moved(StandingTum14(), 0.0, 0.75))}),
            LossReason::kElsewhere);
  Pose3d found = StandingTum14();
  found[kAnkle].position_m.y() += 1.0;  // the mean over 14 joints stays small
  EXPECT_EQ(reason({Person(0, found)}), LossReason::kTooFar);
  found[kAnkle].status = JointStatus::kMissing;
  EXPECT_EQ(reason({Person(0, found)}), LossReason::kNoJoint);
}

TEST(PcpTest, LostPartsSayByHowMuch) {
  Pose3d found = StandingTum14();
  found[kAnkle].position_m.y() += 1.0;
  found[kKnee].position_m.y() += 0.125;
  const PcpResult result = Evaluate(found, Plain());
  ASSERT_EQ(result.lost.size(), 1u);
  const LostPart& lost = result.lost[0];
  EXPECT_EQ(lost.part, kRightLowerLeg);
  EXPECT_STREQ(PcpPartName(lost.part), "r_lower_leg");
  EXPECT_EQ(lost.predicted, TrackId(7));
  EXPECT_EQ(lost.length_m, 0.5);
  EXPECT_EQ(lost.first_error_m, 1.0);
  EXPECT_EQ(lost.second_error_m, 0.125);
}

TEST(PcpTest, MissingJointMakesItsPartsWrong) {
  Pose3d found = StandingTum14();
  found[kKnee] = Joint3d{};
  const PcpResult result = Evaluate(found, Plain());
  ASSERT_EQ(result.lost.size(), 2u);  // both parts that end at the knee
  EXPECT_EQ(result.lost[0].first_error_m, 0.0);
  EXPECT_FALSE(result.lost[0].second_error_m.has_value());
}

TEST(PcpTest, HeadWithoutSourceLosesHeadAndTorso) {
  Pose3d found = StandingTum14();
  found[12] = Joint3d{};
  const PcpResult result = Evaluate(found, Plain());
  ASSERT_EQ(result.lost.size(), 2u);
  EXPECT_STREQ(PcpPartName(result.lost[0].part), "head");
  EXPECT_STREQ(PcpPartName(result.lost[1].part), "torso");
}

TEST(PcpTest, TorsoEndsAtTheMiddleOfTheHips) {
  // The torso is 0.5 m long. One hip off by 1 moves the middle by 0.5, whose
  // mean with a perfect head bottom is 0.25: the limit. Upper legs: 0.5.
  Pose3d found = StandingTum14();
  found[2].position_m.y() += 1.0;
  PcpResult result = Evaluate(found, Plain());
  ASSERT_EQ(result.lost.size(), 1u);
  EXPECT_STREQ(PcpPartName(result.lost[0].part), "r_upper_leg");
  found[2].position_m.y() += 0x1p-10;
  EXPECT_EQ(Evaluate(found, Plain()).lost.size(), 2u);
}

TEST(PcpTest, NoPredictionLosesAllParts) {
  const TrackSequence truth = Tracks({Frame(0, {Person(0, StandingTum14())}),
                                      Frame(1, {Person(0, StandingTum14())})});
  const TrackSequence tracks = Tracks({Frame(0, {})});  // frame 1 not there
  const PcpResult result = EvaluatePcp(truth, tracks, Plain());
  EXPECT_EQ(CountParts(result, 0, PcpGroup::kTotal).total, 20);
  EXPECT_EQ(CountParts(result, 0, PcpGroup::kTotal).count, 0);
  ASSERT_EQ(result.lost.size(), 20u);
  EXPECT_FALSE(result.lost[0].predicted.has_value());

  PcpProtocol skipping = Plain();
  skipping.skip_unmatched = true;
  EXPECT_TRUE(EvaluatePcp(truth, tracks, skipping).person_frames.empty());
}

TEST(PcpTest, APersonWithoutJointsIsNoPrediction) {
  const PcpResult result = Evaluate(Pose3d(14), Plain());
  EXPECT_EQ(result.lost.size(), 10u);
  EXPECT_FALSE(result.person_frames[0].predicted.has_value());
}

TEST(PcpTest, NearestIsNotExclusiveAndHasNoGate) {
  const TrackSequence truth = Tracks(
      {Frame(0, {Person(0, StandingTum14()), Person(1, StandingTum14(0.5)),
                 Person(2, StandingTum14(50.0))})});
  const TrackSequence tracks =
      Tracks({Frame(0, {Person(4, StandingTum14(0.25))})});
  PcpResult result = EvaluatePcp(truth, tracks, Plain());
  for (const PcpPersonFrame& person : result.person_frames) {
    EXPECT_EQ(person.predicted, TrackId(4));
  }
  PcpProtocol one_to_one = Plain();
  one_to_one.matching = PersonMatching::kOneToOne;
  result = EvaluatePcp(truth, tracks, one_to_one);
  int predicted = 0;
  for (const PcpPersonFrame& person : result.person_frames) {
    predicted += person.predicted.has_value() ? 1 : 0;
  }
  EXPECT_EQ(predicted, 1);
  EXPECT_FALSE(result.person_frames[2].predicted.has_value());
}

TEST(PcpTest, OneToOneKeepsItsGate) {
  PcpProtocol one_to_one = Plain();
  one_to_one.matching = PersonMatching::kOneToOne;
  EXPECT_TRUE(Evaluate(StandingTum14(0.5), one_to_one)
                  .person_frames[0]
                  .predicted.has_value());
  EXPECT_FALSE(Evaluate(StandingTum14(0.5625), one_to_one)
                   .person_frames[0]
                   .predicted.has_value());
}

TEST(PcpTest, NearestTakesTheMeanOverPresentJoints) {
  // Person 4 has one joint, 1 m off; person 5 all of them, each 0.5 m off. The
  // sums of squares are 1 and 3.5, the means 1 and 0.25.
  Pose3d few(14);
  few[0] = Observed(0.125, 1.0, 0.0);  // 1 m off
  const TrackSequence truth = Tracks({Frame(0, {Person(0, StandingTum14())})});
  const TrackSequence tracks = Tracks(
      {Frame(0, {Person(4, few), Person(5, Moved(StandingTum14(), 0.5))})});
  EXPECT_EQ(EvaluatePcp(truth, tracks, Plain()).person_frames[0].predicted,
            TrackId(5));
}

TEST(PcpTest, OfTwoEquallyNearTheFirstCounts) {
  const TrackSequence truth = Tracks({Frame(0, {Person(0, StandingTum14())})});
  const TrackSequence tracks = Tracks({Frame(
      0, {Person(8, StandingTum14(0.25)), Person(3, StandingTum14(-0.25))})});
  EXPECT_EQ(EvaluatePcp(truth, tracks, Plain()).person_frames[0].predicted,
            TrackId(8));
}

TEST(PcpTest, PartsWithoutGroundTruthAreNotCounted) {
  Pose3d truth = StandingTum14();
  truth[kAnkle] = Joint3d{};
  const PcpResult result =
      EvaluatePcp(Tracks({Frame(0, {Person(0, truth)})}),
                  Tracks({Frame(0, {Person(0, StandingTum14())})}), Plain());
  EXPECT_EQ(CountParts(result, 0, PcpGroup::kTotal).total, 9);
  EXPECT_EQ(CountParts(result, 0, PcpGroup::kLowerLegs).total, 1);
}

TEST(PcpTest, HeadlineIsThePlainMeanOfItsActors) {
  // Actor 0 right in both frames, actor 1 lost in its one, actor 3 not asked.
  const TrackSequence truth = Tracks(
      {Frame(0, {Person(0, StandingTum14()), Person(1, StandingTum14(9.0))}),
       Frame(1, {Person(0, StandingTum14()), Person(3, StandingTum14(5.0))})});
  const TrackSequence tracks = Tracks({Frame(0, {Person(0, StandingTum14())}),
                                       Frame(1, {Person(0, StandingTum14())})});
  PcpProtocol protocol;  // actors 0, 1, 2
  const PcpResult result = EvaluatePcp(truth, tracks, protocol);
  EXPECT_EQ(result.HeadlineActors(), (std::vector<int64_t>{0, 1}));
  EXPECT_EQ(result.Actors(), (std::vector<int64_t>{0, 1, 3}));
  EXPECT_DOUBLE_EQ(MeanOfActors(result, PcpGroup::kTotal), 50.0);
  const Share pooled = PooledParts(result, PcpGroup::kTotal);
  EXPECT_EQ(pooled.count, 20);
  EXPECT_EQ(pooled.total, 30);
}

TEST(PcpTest, TimeGapPicksTheNearestFrame) {
  const TrackSequence truth = Tracks({Frame(10, {Person(0, StandingTum14())})});
  // Frames of 25 Hz: 0.08 s before and after, of which the earlier counts.
  const TrackSequence tracks =
      Tracks({Frame(7, {}), Frame(8, {Person(4, StandingTum14())}),
              Frame(12, {Person(5, StandingTum14())})});
  const auto predicted = [&](double max_time_gap_s) {
    PcpProtocol protocol = Plain();
    protocol.max_time_gap_s = max_time_gap_s;
    return EvaluatePcp(truth, tracks, protocol).person_frames[0].predicted;
  };
  EXPECT_EQ(predicted(0.0), std::nullopt);
  EXPECT_EQ(predicted(0.079), std::nullopt);
  EXPECT_EQ(predicted(0.08), TrackId(4));
  EXPECT_EQ(predicted(1.0), TrackId(4));
}

TEST(PcpTest, OnlyTheProtocolsFramesCount) {
  PcpProtocol protocol = Plain();
  protocol.frames = {{1, 2}, {5, 6}};
  std::vector<TrackFrame> frames;
  for (int frame = 0; frame < 8; ++frame) {
    frames.push_back(Frame(frame, {Person(0, StandingTum14())}));
  }
  const PcpResult result =
      EvaluatePcp(Tracks(frames), Tracks(frames), protocol);
  ASSERT_EQ(result.person_frames.size(), 2u);
  EXPECT_EQ(result.person_frames[0].frame, 1);
  EXPECT_EQ(result.person_frames[1].frame, 5);
}

TEST(PcpTest, NothingToScore) {
  const PcpResult result = EvaluatePcp(Tracks({}), Tracks({}), Plain());
  EXPECT_TRUE(result.person_frames.empty());
  EXPECT_TRUE(std::isnan(MeanOfActors(result, PcpGroup::kTotal)));
  EXPECT_TRUE(std::isnan(MeanOfActorsInterval(result, PcpGroup::kTotal).low));
}

TEST(PcpTest, IntervalHoldsTheScore) {
  std::vector<TrackFrame> truth;
  std::vector<TrackFrame> tracks;
  for (int frame = 0; frame < 100; ++frame) {
    truth.push_back(Frame(frame, {Person(0, StandingTum14())}));
    Pose3d found = StandingTum14();
    if (frame % 2 == 0) found[kAnkle].position_m.y() += 2.0;
    tracks.push_back(Frame(frame, {Person(0, found)}));
  }
  const PcpResult worse = EvaluatePcp(Tracks(truth), Tracks(tracks), Plain());
  const PcpResult best = EvaluatePcp(Tracks(truth), Tracks(truth), Plain());
  EXPECT_DOUBLE_EQ(MeanOfActors(worse, PcpGroup::kTotal), 95.0);
  const Interval interval = ActorInterval(worse, 0, PcpGroup::kTotal);
  EXPECT_LT(interval.low, 95.0);
  EXPECT_GT(interval.high, 95.0);
  const Interval difference =
      MeanOfActorsDifference(best, worse, PcpGroup::kTotal);
  EXPECT_GT(difference.low, 4.0);
  EXPECT_LT(difference.high, 6.0);
  PcpProtocol fewer = Plain();
  fewer.frames = {{0, 50}};
  EXPECT_THROW(MeanOfActorsDifference(
                   best, EvaluatePcp(Tracks(truth), Tracks(tracks), fewer),
                   PcpGroup::kTotal),
               OptionError);
}

TEST(PcpProtocolTest, ByName) {
  EXPECT_EQ(PcpProtocolByName("shelf")->frames[0].end, 601);
  EXPECT_EQ(PcpProtocolByName("campus")->frames.size(), 2u);
  EXPECT_EQ(PcpProtocolByName("campus_extended")->frames.size(), 1u);
  EXPECT_TRUE(PcpProtocolByName("4d_association")->strictly_less);
  EXPECT_FALSE(PcpProtocolByName("mall").has_value());
}

}  // namespace
}  // namespace kinegraph
