#include "core/evaluation/pcp.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "tests/core/evaluation/people.h"

namespace kinegraph::testing {
namespace {

using Eigen::Vector3d;

constexpr int kAnkle = 0;
constexpr int kKnee = 1;

PcpProtocol Plain() {
  PcpProtocol protocol;
  protocol.headline_actors = {};
  return protocol;
}

PcpResult Evaluate(const Pose3d& found, const PcpProtocol& protocol) {
  return EvaluatePcp(Alone(), Alone(found, 7), protocol);
}

// Names of the lost parts, i.e. those that are not correct.
std::vector<std::string> Lost(const Pose3d& found,
                              const PcpProtocol& protocol = Plain()) {
  std::vector<std::string> names;
  for (const LostPart& part : Evaluate(found, protocol).lost) {
    names.push_back(PcpPartName(part.part));
  }
  return names;
}
using Names = std::vector<std::string>;

// A standing person with one joint displaced forward [m].
Pose3d Forward(int joint, double by_m) {
  Pose3d pose = StandingTum14();
  pose[joint].position_m.y() += by_m;
  return pose;
}

Pose3d Without(int joint) {
  Pose3d pose = StandingTum14();
  pose[joint] = Joint3d{};
  return pose;
}

TEST(PcpTest, PerfectPredictionScoresAllParts) {
  const PcpResult result = Evaluate(StandingTum14(), Plain());
  EXPECT_EQ(CountParts(result, 0, PcpGroup::kTotal).count, 10);
  EXPECT_EQ(CountParts(result, 0, PcpGroup::kTotal).total, 10);
  EXPECT_EQ(CountParts(result, 0, PcpGroup::kLowerArms).total, 2);
  EXPECT_EQ(CountParts(result, 0, PcpGroup::kHead).total, 1);
  EXPECT_TRUE(result.lost.empty());
  EXPECT_EQ(MeanOfActors(result, PcpGroup::kTotal), 100.0);
}

// The lower leg is 0.5 m long: the limit of an end's error, or of the mean of
// both, is 0.25 m.
TEST(PcpTest, EndpointRulesIncludeTheLimitUnlessStrictlyLess) {
  const Names leg = {"r_lower_leg"};
  PcpProtocol mean = Plain(), each = Plain();
  each.endpoints = EndpointRule::kEach;
  EXPECT_EQ(Lost(Forward(kAnkle, 0.5), mean), Names()) << "the limit itself";
  EXPECT_EQ(Lost(Forward(kAnkle, 0.5 + 0x1p-20), mean), leg);
  EXPECT_EQ(Lost(Forward(kAnkle, 0.25), each), Names());
  EXPECT_EQ(Lost(Forward(kAnkle, 0.3125), each), leg) << "correct by the mean";
  mean.strictly_less = each.strictly_less = true;
  EXPECT_EQ(Lost(Forward(kAnkle, 0.5), mean), leg);
  EXPECT_EQ(Lost(Forward(kAnkle, 0.25), each), leg);
}

TEST(PcpTest, LostPartsHaveAReason) {
  const auto reason = [](const std::vector<PersonPose>& found) {
    return EvaluatePcp(Alone(), Tracks({Frame(0, found)}), Plain())
        .lost.at(0)
        .reason();
  };
  EXPECT_EQ(reason({}), LossReason::kNoPose);
  EXPECT_EQ(reason({Person(0, Pose3d(14))}), LossReason::kNoPose);
  EXPECT_EQ(reason({Person(0, Moved(StandingTum14(), 0.0, 0.75))}),
            LossReason::kElsewhere);
  // The mean over 14 joints stays small.
  EXPECT_EQ(reason({Person(0, Forward(kAnkle, 1.0))}), LossReason::kTooFar);
  EXPECT_EQ(reason({Person(0, Without(kAnkle))}), LossReason::kNoJoint);
}

TEST(PcpTest, LostPartsHaveErrors) {
  Pose3d found = Forward(kAnkle, 1.0);
  found[kKnee].position_m.y() += 0.125;
  const PcpResult result = Evaluate(found, Plain());
  ASSERT_EQ(result.lost.size(), 1u);
  const LostPart& lost = result.lost[0];
  EXPECT_STREQ(PcpPartName(lost.part), "r_lower_leg");
  EXPECT_EQ(lost.predicted, TrackId(7));
  EXPECT_EQ(lost.length_m, 0.5);
  EXPECT_EQ(lost.first_error_m, 1.0);
  EXPECT_EQ(lost.second_error_m, 0.125);
}

TEST(PcpTest, MissingJointsMakePartsWrong) {
  EXPECT_EQ(Lost(Without(kKnee)), (Names{"r_lower_leg", "r_upper_leg"}));
  EXPECT_EQ(Lost(Without(12)), (Names{"head", "torso"}));
  const PcpResult result = Evaluate(Without(kKnee), Plain());
  EXPECT_EQ(result.lost[0].first_error_m, 0.0);
  EXPECT_FALSE(result.lost[0].second_error_m.has_value());
  // Without ground truth a part is not counted.
  const PcpResult other = EvaluatePcp(Alone(Without(kAnkle)), Alone(), Plain());
  EXPECT_EQ(CountParts(other, 0, PcpGroup::kTotal).total, 9);
  EXPECT_EQ(CountParts(other, 0, PcpGroup::kLowerLegs).total, 1);
}

TEST(PcpTest, TorsoEndsAtTheMiddleOfTheHips) {
  // The torso is 0.5 m long. One hip off by 1 m moves the middle by 0.5 m,
  // whose mean with a perfect head bottom is 0.25 m: the limit. The upper leg's
  // mean is 0.5 m.
  EXPECT_EQ(Lost(Forward(2, 1.0)), Names{"r_upper_leg"});
  EXPECT_EQ(Lost(Forward(2, 1.0 + 0x1p-10)), (Names{"r_upper_leg", "torso"}));
}

TEST(PcpTest, NoPredictionLosesAllParts) {
  const TrackSequence truth = Alone(StandingTum14(), 0, 2);
  const TrackSequence tracks = Tracks({Frame(0, {})});  // without frame 1
  const PcpResult result = EvaluatePcp(truth, tracks, Plain());
  EXPECT_EQ(CountParts(result, 0, PcpGroup::kTotal).total, 20);
  EXPECT_EQ(CountParts(result, 0, PcpGroup::kTotal).count, 0);
  ASSERT_EQ(result.lost.size(), 20u);
  EXPECT_FALSE(result.lost[0].predicted.has_value());
  PcpProtocol skipping = Plain();
  skipping.skip_unmatched = true;
  EXPECT_TRUE(EvaluatePcp(truth, tracks, skipping).person_frames.empty());
}

// The predicted person matched with each true person; -1 if none.
std::vector<int64_t> Taken(const std::vector<PersonPose>& truth,
                           const std::vector<PersonPose>& found,
                           PersonMatching matching) {
  PcpProtocol protocol = Plain();
  protocol.matching = matching;
  std::vector<int64_t> taken;
  for (const PcpPersonFrame& person :
       EvaluatePcp(Tracks({Frame(0, truth)}), Tracks({Frame(0, found)}),
                   protocol)
           .person_frames) {
    taken.push_back(person.predicted ? person.predicted->value() : -1);
  }
  return taken;
}

TEST(PcpTest, MatchesPeopleByTheProtocol) {
  using Ids = std::vector<int64_t>;
  constexpr auto kNearest = PersonMatching::kNearest;
  constexpr auto kOneToOne = PersonMatching::kOneToOne;
  const auto at = [](int64_t id, double x) {
    return Person(id, StandingTum14(x));
  };
  // Nearest is not exclusive and has no gate.
  EXPECT_EQ(Taken({at(0, 0), at(1, 0.5), at(2, 50)}, {at(4, 0.25)}, kNearest),
            (Ids{4, 4, 4}));
  const Ids one =
      Taken({at(0, 0), at(1, 0.5), at(2, 50)}, {at(4, 0.25)}, kOneToOne);
  EXPECT_EQ(std::count(one.begin(), one.end(), 4), 1);
  EXPECT_EQ(one[2], -1);
  // The gate includes its limit.
  EXPECT_EQ(Taken({at(0, 0)}, {at(7, 0.5)}, kOneToOne), Ids{7});
  EXPECT_EQ(Taken({at(0, 0)}, {at(7, 0.5625)}, kOneToOne), Ids{-1});
  // Of two equally near people the first is matched.
  EXPECT_EQ(Taken({at(0, 0)}, {at(8, 0.25), at(3, -0.25)}, kNearest), Ids{8});
  // The mean over existing joints: person 4 has one joint, 1 m off; person 5
  // all of them, each 0.5 m off. The sums of squares are 1 and 3.5, the means 1
  // and 0.25.
  Pose3d few(14);
  few[0] = Observed(0.125, 1.0, 0.0);
  EXPECT_EQ(Taken({at(0, 0)}, {Person(4, few), at(5, 0.5)}, kNearest), Ids{5});
}

TEST(PcpTest, HeadlineIsTheUnweightedMeanOfActors) {
  // Actor 0 is correct in both frames, actor 1 is lost in its only frame, and
  // actor 3 is not part of the headline.
  const PcpResult result =
      EvaluatePcp(Standing("0@0 1@9 | 0@0 3@5"), Standing("0@0 | 0@0"),
                  PcpProtocol());  // actors 0, 1, 2
  EXPECT_EQ(result.HeadlineActors(), (std::vector<int64_t>{0, 1}));
  EXPECT_EQ(result.Actors(), (std::vector<int64_t>{0, 1, 3}));
  EXPECT_DOUBLE_EQ(MeanOfActors(result, PcpGroup::kTotal), 50.0);
  EXPECT_EQ(PooledParts(result, PcpGroup::kTotal).count, 20);
  EXPECT_EQ(PooledParts(result, PcpGroup::kTotal).total, 30);
}

TEST(PcpTest, TimeGapPicksTheNearestFrame) {
  const TrackSequence truth = Tracks({Frame(10, {Person(0, StandingTum14())})});
  // At 25 Hz, frames 8 and 12 are 0.08 s away; the earlier one counts.
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

TEST(PcpTest, TimeGapNeedsNoTimesOfTheTruth) {
  TrackSequence truth =
      Tracks({Frame(9, {}), Frame(10, {Person(0, StandingTum14())})});
  truth.header.frame_rate_hz = 0.0;
  for (TrackFrame& frame : truth.frames) frame.time = 0;
  const TrackSequence tracks = Tracks({Frame(0, {Person(3, StandingTum14())}),
                                       Frame(8, {Person(4, StandingTum14())})});
  PcpProtocol protocol = Plain();
  protocol.max_time_gap_s = 0.1;
  const PcpResult result = EvaluatePcp(truth, tracks, protocol);
  ASSERT_EQ(result.person_frames.size(), 1u);
  EXPECT_EQ(result.person_frames[0].predicted, TrackId(4));
}

TEST(PcpTest, OnlyTheProtocolsFramesCount) {
  PcpProtocol protocol = Plain();
  protocol.frames = {{1, 2}, {5, 6}};
  const TrackSequence eight = Alone(StandingTum14(), 0, 8);
  const PcpResult result = EvaluatePcp(eight, eight, protocol);
  ASSERT_EQ(result.person_frames.size(), 2u);
  EXPECT_EQ(result.person_frames[0].frame, 1);
  EXPECT_EQ(result.person_frames[1].frame, 5);
  const PcpResult nothing = EvaluatePcp(Tracks({}), Tracks({}), Plain());
  EXPECT_TRUE(nothing.person_frames.empty());
  EXPECT_TRUE(std::isnan(MeanOfActors(nothing, PcpGroup::kTotal)));
  EXPECT_TRUE(std::isnan(MeanOfActorsInterval(nothing, PcpGroup::kTotal).low));
}

TEST(PcpTest, IntervalContainsTheScore) {
  const TrackSequence truth = Alone(StandingTum14(), 0, 100);
  TrackSequence tracks = truth;
  for (size_t f = 0; f < 100; f += 2) {
    tracks.frames[f].people[0].joints = Forward(kAnkle, 2.0);
  }
  const PcpResult worse = EvaluatePcp(truth, tracks, Plain());
  const PcpResult best = EvaluatePcp(truth, truth, Plain());
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
  EXPECT_THROW(MeanOfActorsDifference(best, EvaluatePcp(truth, tracks, fewer),
                                      PcpGroup::kTotal),
               OptionError);
}

TEST(PcpProtocolTest, IsFoundByName) {
  EXPECT_EQ(PcpProtocolByName("shelf")->frames[0].end, 601);
  EXPECT_EQ(PcpProtocolByName("campus")->frames.size(), 2u);
  EXPECT_EQ(PcpProtocolByName("campus_extended")->frames.size(), 1u);
  EXPECT_TRUE(PcpProtocolByName("4d_association")->strictly_less);
  EXPECT_FALSE(PcpProtocolByName("mall").has_value());
}

// ---- Heads

constexpr int kBottom = 12;
constexpr int kTop = 13;

// Faces +y. Middle of the shoulders m = (0, 0, 1.5), nose n = (0, 0.2, 1.7),
// middle of the ears e = (0, 0.1, 1.7).
Pose3d CocoPerson() {
  Pose3d pose(17);
  const std::vector<int> coco_of_tum = {16, 14, 12, 11, 13, 15,
                                        10, 8,  6,  5,  7,  9};
  const Pose3d body = StandingTum14();
  for (int j = 0; j < 12; ++j) pose[coco_of_tum[j]] = body[j];
  pose[0] = Observed(0.0, 0.2, 1.7);
  pose[1] = Observed(-0.03, 0.18, 1.75);
  pose[2] = Observed(0.03, 0.18, 1.75);
  pose[3] = Observed(-0.08, 0.1, 1.7);
  pose[4] = Observed(0.08, 0.1, 1.7);
  return pose;
}

void ExpectNear(const Vector3d& found, const Vector3d& expected) {
  // A few rounding errors of numbers below 2.
  EXPECT_LT((found - expected).norm(), 1e-14)
      << found.transpose() << " instead of " << expected.transpose();
}

TEST(HeadConversionTest, MatchesHandComputedValues) {
  // The face direction in k4d, (0, 0, 1.5 - 1) x (0.5, 0, 0), points along +y.
  struct Head {
    HeadConversion conversion;
    Vector3d bottom, top;
  };
  for (const auto& [conversion, bottom, top] :
       {Head{HeadConversion::kChu, {0, 0.08, 1.62}, {0, 0.1, 1.8}},
        Head{HeadConversion::kMvpose, {0, 0.1, 1.6}, {0, 0.15, 1.8}},
        Head{HeadConversion::kVoxelposeCampus, {0, 0.05, 1.6}, {0, 0.15, 1.8}},
        Head{HeadConversion::kVoxelposeShelf, {0, 0.0875, 1.6}, {0, 0.15, 1.8}},
        Head{HeadConversion::k4d, {0, 0.05, 1.6}, {0, 0.175, 1.745}},
        Head{HeadConversion::kRaw, {0, 0, 1.5}, {0, 0.2, 1.7}}}) {
    SCOPED_TRACE(ToString(conversion));
    const Pose3d pose = Tum14Converter(Coco17(), conversion)(CocoPerson());
    ASSERT_EQ(pose.size(), 14u);
    ExpectNear(pose[kBottom].position_m, bottom);
    ExpectNear(pose[kTop].position_m, top);
    for (int j = 0; j < 12; ++j) {
      EXPECT_EQ(pose[j].position_m, StandingTum14()[j].position_m);
      EXPECT_TRUE(pose[j].present());
    }
  }
}

TEST(HeadConversionTest, WeightsApplyToWorldAxes) {
  // If the head faces +x, the forward offsets have other factors: 0.78 instead
  // of 0.5 for the top, and 0.3 instead of 0.4 for the bottom.
  Pose3d pose = CocoPerson();
  pose[0] = Observed(0.2, 0.0, 1.7);
  const Pose3d converted = Tum14Converter(Coco17(), HeadConversion::kChu)(pose);
  ExpectNear(converted[kTop].position_m, {0.156, 0, 1.8});
  ExpectNear(converted[kBottom].position_m, {0.06, 0, 1.62});
}

TEST(HeadConversionTest, FourDUsesNeckAndMidHipOfThePose) {
  Pose3d pose(FourDA19().joint_count());
  const std::vector<int> coco = MapByName(Coco17(), FourDA19());
  for (int j = 0; j < FourDA19().joint_count(); ++j) {
    if (coco[j] >= 0) pose[j] = CocoPerson()[coco[j]];
  }
  const int neck = FourDA19().IndexOf("neck");
  const int mid_hip = FourDA19().IndexOf("mid_hip");
  const Tum14Converter convert(FourDA19(), HeadConversion::k4d);
  // Without a neck, the middle of the shoulders is used, as for COCO.
  ExpectNear(convert(pose)[kTop].position_m, {0, 0.175, 1.745});
  // A trunk leaning back by 3:4 rotates the face up: (0, -0.3, 0.4) x (1, 0, 0)
  // = (0, 0.4, 0.3), of length 0.5.
  pose[mid_hip] = Observed(0.0, 0.0, 1.0);
  pose[neck] = Observed(0.0, -0.3, 1.4);
  ExpectNear(convert(pose)[kTop].position_m,
             {0, 0.05 + 0.125 * 0.8, 1.6 + 0.125 * 0.6 + 0.145});
}

TEST(HeadConversionTest, MissingJointsStayMissing) {
  Pose3d pose = CocoPerson();
  pose[0] = Joint3d{};   // nose
  pose[15] = Joint3d{};  // l_ankle
  const auto convert = [&](HeadConversion conversion) {
    return Tum14Converter(Coco17(), conversion)(pose);
  };
  for (const HeadConversion conversion :
       {HeadConversion::kChu, HeadConversion::kMvpose,
        HeadConversion::kVoxelposeShelf}) {
    EXPECT_FALSE(convert(conversion)[kBottom].present());
    EXPECT_FALSE(convert(conversion)[kTop].present());
    EXPECT_FALSE(convert(conversion)[5].present());
    EXPECT_TRUE(convert(conversion)[4].present());
  }
  EXPECT_TRUE(convert(HeadConversion::k4d)[kTop].present());
  EXPECT_TRUE(convert(HeadConversion::kRaw)[kBottom].present());
  EXPECT_FALSE(convert(HeadConversion::kRaw)[kTop].present());
}

TEST(HeadConversionTest, AComputedJointHasTheStatusOfItsWorstSource) {
  Pose3d pose = CocoPerson();
  pose[5].status = JointStatus::kInferred;  // l_shoulder
  const Pose3d converted = Tum14Converter(Coco17(), HeadConversion::kChu)(pose);
  EXPECT_EQ(converted[kTop].status, JointStatus::kInferred);
  EXPECT_EQ(converted[8].status, JointStatus::kObserved);
}

TEST(HeadConversionTest, ConversionsThatUseEarsNeedEars) {
  const Skeleton body("body", {"nose", "l_shoulder", "r_shoulder"}, {});
  const Pose3d pose = {Observed(0, 0.2, 1.7), Observed(-0.2, 0, 1.5),
                       Observed(0.2, 0, 1.5)};
  const auto convert = [&](HeadConversion conversion) {
    return Tum14Converter(body, conversion)(pose);
  };
  EXPECT_FALSE(convert(HeadConversion::kVoxelposeCampus)[kTop].present());
  EXPECT_FALSE(convert(HeadConversion::k4d)[kTop].present());
  EXPECT_TRUE(convert(HeadConversion::kChu)[kTop].present());
  EXPECT_FALSE(convert(HeadConversion::kChu)[0].present());
}

TEST(HeadConversionTest, GroundTruthKeepsStoredHead) {
  const Pose3d pose =
      Tum14Converter(Tum14(), HeadConversion::kChu)(StandingTum14());
  EXPECT_EQ(pose[kBottom].position_m, Vector3d(0, 0, 1.5));
  EXPECT_EQ(pose[kTop].position_m, Vector3d(0, 0, 1.75));
}

TEST(HeadConversionTest, IsFoundByName) {
  EXPECT_EQ(HeadConversionByName("voxelpose", true),
            HeadConversion::kVoxelposeCampus);
  EXPECT_EQ(HeadConversionByName("voxelpose", false),
            HeadConversion::kVoxelposeShelf);
  EXPECT_EQ(HeadConversionByName("4d", false), HeadConversion::k4d);
  EXPECT_FALSE(HeadConversionByName("nose", false).has_value());
}

}  // namespace
}  // namespace kinegraph::testing
