#include "core/evaluation/correspondence.h"

#include <gtest/gtest.h>

#include "core/base/constants.h"
#include "tests/core/evaluation/people.h"

namespace kinegraph::testing {
namespace {

TEST(FindFrameTest, FindsByNumber) {
  const TrackSequence tracks = Tracks({Frame(3, {}), Frame(7, {})});
  EXPECT_EQ(FindFrame(tracks, 7), &tracks.frames[1]);
  EXPECT_EQ(FindFrame(tracks, 5), nullptr);
  EXPECT_EQ(FindFrame(tracks, 8), nullptr);
  EXPECT_EQ(FindFrame(Tracks({}), 3), nullptr);
}

TEST(CommonJointsTest, AreMatchedByName) {
  EXPECT_EQ(CommonJoints(Tum14(), Coco17()).size(), 12u);
  EXPECT_EQ(CommonJoints(Coco17(), Body25()).size(), 17u);
  const JointPairs body = CommonBodyJoints(Coco17(), Body25());
  EXPECT_EQ(body.size(), 12u);  // without the face
  for (const JointPair& pair : body) {
    EXPECT_EQ(Coco17().joints()[pair.a], Body25().joints()[pair.b]);
  }
  const Skeleton hand("hand", {"thumb", "palm"}, {});
  EXPECT_EQ(CommonBodyJoints(hand, hand).size(), 2u);
}

TEST(MeanDistanceTest, SkipsMissingJoints) {
  const JointPairs joints = CommonJoints(Tum14(), Tum14());
  Pose3d moved = Moved(StandingTum14(), 3.0, 4.0);
  EXPECT_DOUBLE_EQ(*MeanDistance(StandingTum14(), moved, joints), 5.0);
  moved[0] = Joint3d{};
  EXPECT_DOUBLE_EQ(*MeanDistance(StandingTum14(), moved, joints), 5.0);
  EXPECT_FALSE(MeanDistance(StandingTum14(), Pose3d(14), joints).has_value());
}

TEST(MatchOneToOneTest, PrefersMorePairsThenLessCost) {
  Eigen::MatrixXd cost(2, 2);
  cost << 0.1, 0.5,  //
      0.2, 9.0;
  // Column 0 is cheapest for row 0, but then row 1 has no column within the
  // gate.
  const std::vector<CostPair> pairs = MatchOneToOne(cost, 1.0);
  ASSERT_EQ(pairs.size(), 2u);
  EXPECT_EQ(pairs[0].column, 1);
  EXPECT_EQ(pairs[1].column, 0);
  EXPECT_EQ(pairs[1].cost, 0.2);
}

TEST(MatchOneToOneTest, GateIncludesItsLimit) {
  Eigen::MatrixXd cost(1, 2);
  cost << 0.5, kNan;
  EXPECT_EQ(MatchOneToOne(cost, 0.5).size(), 1u);
  EXPECT_TRUE(MatchOneToOne(cost, 0.4999).empty());
  cost << kNan, kNan;
  EXPECT_TRUE(MatchOneToOne(cost, kNoGate).empty());
}

TEST(MatchOneToOneTest, EmptyMatricesHaveNoPairs) {
  EXPECT_TRUE(MatchOneToOne(Eigen::MatrixXd(0, 3), 1.0).empty());
  EXPECT_TRUE(MatchOneToOne(Eigen::MatrixXd(3, 0), 1.0).empty());
  EXPECT_TRUE(MatchOneToOne(Eigen::MatrixXd(0, 0), 1.0).empty());
}

TEST(PairPeopleTest, KeepsTruePeopleWithoutCounterpart) {
  const TrackSequence truth = Standing("0@0 1@2 | 0@0 |");
  const TrackSequence tracks = Standing("5@2.25");
  const auto pairs_of = [&](const std::vector<FrameRange>& frames) {
    return PairPeople(truth, tracks, CommonJoints(Tum14(), Tum14()), 0.5,
                      frames);
  };
  const std::vector<PersonPair> pairs = pairs_of({});
  ASSERT_EQ(pairs.size(), 3u);
  EXPECT_EQ(pairs[0].found, nullptr);
  ASSERT_NE(pairs[1].found, nullptr);
  EXPECT_EQ(pairs[1].found->id, TrackId(5));
  EXPECT_EQ(pairs[2].frame, 1);
  EXPECT_EQ(pairs[2].found, nullptr);
  EXPECT_EQ(pairs_of({{1, 2}}).size(), 1u);
}

}  // namespace
}  // namespace kinegraph::testing
