#include "core/evaluation/identity.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/evaluation/people.h"

namespace kinegraph {
namespace {

using testing::Frame;
using testing::Person;
using testing::StandingTum14;
using testing::Tracks;

// People as (id, place) pairs.
struct At {
  int64_t id;
  double x;
};

TrackSequence Make(const std::vector<std::vector<At>>& frames) {
  std::vector<TrackFrame> made;
  for (size_t k = 0; k < frames.size(); ++k) {
    std::vector<PersonPose> people;
    for (const At& at : frames[k]) {
      people.push_back(Person(at.id, StandingTum14(at.x)));
    }
    made.push_back(Frame(static_cast<int64_t>(k), people));
  }
  return Tracks(made);
}

TEST(IdentityTest, PerfectTracks) {
  const TrackSequence truth = Make({{{0, 0.0}, {1, 3.0}}, {{0, 0.0}}});
  const TrackSequence found = Make({{{7, 0.25}, {5, 3.0}}, {{7, 0.0}}});
  const IdentityResult result = EvaluateIdentity(truth, found);
  EXPECT_EQ(result.Mota(), 1.0);
  EXPECT_EQ(result.Idf1(), 1.0);
  EXPECT_EQ(result.switches, 0);
  EXPECT_EQ(result.fragments, 0);
  EXPECT_EQ(result.true_people, 2);
  EXPECT_EQ(result.identities, 2);
}

TEST(IdentityTest, SwitchInTheMiddle) {
  // Four frames of one person: identity 1 twice, then identity 2 twice.
  const IdentityResult result =
      EvaluateIdentity(Make({{{0, 0}}, {{0, 0}}, {{0, 0}}, {{0, 0}}}),
                       Make({{{1, 0}}, {{1, 0}}, {{2, 0}}, {{2, 0}}}));
  EXPECT_EQ(result.switches, 1);
  EXPECT_EQ(result.fragments, 0);
  EXPECT_EQ(result.matches, 4);
  EXPECT_DOUBLE_EQ(result.Mota(), 0.75);
  EXPECT_EQ(result.identity_true_positives, 2);
  EXPECT_DOUBLE_EQ(result.Idf1(), 0.5);
}

TEST(IdentityTest, TwoPeopleSwapped) {
  const IdentityResult result =
      EvaluateIdentity(Make({{{0, 0}, {1, 3}}, {{0, 0}, {1, 3}}}),
                       Make({{{4, 0}, {5, 3}}, {{5, 0}, {4, 3}}}));
  EXPECT_EQ(result.switches, 2);
  EXPECT_EQ(result.identity_true_positives, 2);
}

TEST(IdentityTest, GapIsAFragment) {
  const IdentityResult result =
      EvaluateIdentity(Make({{{0, 0}}, {{0, 0}}, {{0, 0}}, {{0, 0}}}),
                       Make({{{1, 0}}, {}, {{1, 0}}, {}}));
  EXPECT_EQ(result.misses, 2);
  EXPECT_EQ(result.fragments, 1);  // not the one that never comes back
  EXPECT_EQ(result.switches, 0);
  EXPECT_DOUBLE_EQ(result.Mota(), 0.5);
}

TEST(IdentityTest, ASwitchAcrossAGapCounts) {
  const IdentityResult result = EvaluateIdentity(
      Make({{{0, 0}}, {{0, 0}}, {{0, 0}}}), Make({{{1, 0}}, {}, {{2, 0}}}));
  EXPECT_EQ(result.switches, 1);
  EXPECT_EQ(result.fragments, 1);
}

TEST(IdentityTest, KeepsItsMatchThoughAnotherComesNearer) {
  const IdentityResult result = EvaluateIdentity(
      Make({{{0, 0}}, {{0, 0}}}), Make({{{1, 0.25}}, {{1, 0.25}, {2, 0.0}}}));
  EXPECT_EQ(result.switches, 0);
  EXPECT_EQ(result.false_positives, 1);
  EXPECT_DOUBLE_EQ(result.Mota(), 0.5);
}

TEST(IdentityTest, FalsePositivesInFramesWithoutTruth) {
  const IdentityResult result =
      EvaluateIdentity(Make({{{0, 0}}}), Make({{{1, 0}}, {{1, 0}}}));
  EXPECT_EQ(result.false_positives, 1);
  EXPECT_EQ(result.Mota(), 0.0);
  EXPECT_DOUBLE_EQ(result.Idf1(), 2.0 / 3.0);
}

TEST(IdentityTest, GateIncludesItsLimit) {
  EXPECT_EQ(EvaluateIdentity(Make({{{0, 0}}}), Make({{{1, 0.5}}})).matches, 1);
  EXPECT_EQ(EvaluateIdentity(Make({{{0, 0}}}), Make({{{1, 0.5625}}})).matches,
            0);
}

TEST(IdentityTest, BestAssignmentIsGlobal) {
  // Identity 1 explains person 0 for two frames and person 1 for one; identity
  // 2 explains person 0 once. Taking (0, 1) leaves nothing for person 1, which
  // still beats (0, 2) with (1, 1).
  const IdentityResult result =
      EvaluateIdentity(Make({{{0, 0}}, {{0, 0}}, {{0, 0}}, {{1, 3}}}),
                       Make({{{1, 0}}, {{1, 0}}, {{2, 0}}, {{1, 3}}}));
  EXPECT_EQ(result.identity_true_positives, 2);
}

TEST(IdentityTest, NobodyAnywhere) {
  const IdentityResult result = EvaluateIdentity(Make({{}}), Make({}));
  EXPECT_TRUE(std::isnan(result.Mota()));
  EXPECT_TRUE(std::isnan(result.Idf1()));
}

}  // namespace
}  // namespace kinegraph
