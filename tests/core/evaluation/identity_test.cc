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
struct Placed {
  int64_t id;
  double x;
};

TrackSequence Make(const std::vector<std::vector<Placed>>& frames) {
  std::vector<TrackFrame> made;
  for (size_t k = 0; k < frames.size(); ++k) {
    std::vector<PersonPose> people;
    for (const Placed& at : frames[k]) {
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

TEST(IdentityTest, WhoHadAnIdentityLastKeepsIt) {
  // Identity 7 goes from person 0 to person 1, and then 0 comes near it, too:
  // 7 stays with 1, whoever stands first in a frame of the truth.
  const TrackSequence found = Make({{{7, 0}}, {{7, 3}}, {{7, 3}, {8, 2.4}}});
  const TrackSequence truths[] = {
      Make({{{0, 0}, {1, 3}}, {{0, 0}, {1, 3}}, {{0, 2.7}, {1, 3}}}),
      Make({{{1, 3}, {0, 0}}, {{1, 3}, {0, 0}}, {{1, 3}, {0, 2.7}}})};
  for (const TrackSequence& truth : truths) {
    const IdentityResult result = EvaluateIdentity(truth, found);
    EXPECT_EQ(result.misses, 2);
    EXPECT_EQ(result.false_positives, 0);
    EXPECT_EQ(result.switches, 1);  // of person 0, from 7 to 8
    EXPECT_DOUBLE_EQ(result.Mota(), 0.5);
  }
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

TEST(IdentityTest, FramesThatTruthDoesNotHaveAreNotScored) {
  const IdentityResult result =
      EvaluateIdentity(Make({{{0, 0}}}), Make({{{1, 0}}, {{1, 0}}}));
  EXPECT_EQ(result.false_positives, 0);
  EXPECT_EQ(result.Idf1(), 1.0);
  EXPECT_EQ(result.Hota().hota, 1.0);
}

TEST(IdentityTest, FalsePositivesInFramesWithNobody) {
  const IdentityResult result =
      EvaluateIdentity(Make({{{0, 0}}, {}}), Make({{{1, 0}}, {{1, 0}}}));
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
  EXPECT_TRUE(std::isnan(result.Hota().hota));
}

// ---- HOTA, worked by hand

TEST(HotaTest, ASwitchInTheMiddle) {
  // One person for four frames, two identities of two frames each. Every pose
  // is matched: DetA = 1. Each identity shares 2 of 4 + 2 - 2 frames, so each
  // match counts a half: AssA = 1/2, HOTA = sqrt(1/2).
  const IdentityResult result =
      EvaluateIdentity(Make({{{0, 0}}, {{0, 0}}, {{0, 0}}, {{0, 0}}}),
                       Make({{{1, 0}}, {{1, 0}}, {{2, 0}}, {{2, 0}}}));
  const HotaScores hota = result.Hota();
  EXPECT_DOUBLE_EQ(hota.detection, 1.0);
  EXPECT_DOUBLE_EQ(hota.association, 0.5);
  EXPECT_DOUBLE_EQ(hota.hota, std::sqrt(0.5));
  EXPECT_DOUBLE_EQ(hota.localisation, 1.0);
}

TEST(HotaTest, MissesAndFalsePositives) {
  // Truth: person 0 in four frames. Found: identity 1 on them in the first
  // two, and identity 9 elsewhere in the last. TP 2, FN 2, FP 1: DetA = 2/5.
  // Identity 1 shares 2 of 4 + 2 - 2 frames: AssA = 1/2. HOTA = sqrt(1/5).
  const IdentityResult result =
      EvaluateIdentity(Make({{{0, 0}}, {{0, 0}}, {{0, 0}}, {{0, 0}}}),
                       Make({{{1, 0}}, {{1, 0}}, {}, {{9, 3}}}));
  const HotaScores hota = result.Hota();
  EXPECT_DOUBLE_EQ(hota.detection, 0.4);
  EXPECT_DOUBLE_EQ(hota.association, 0.5);
  EXPECT_DOUBLE_EQ(hota.hota, std::sqrt(0.2));
}

TEST(HotaTest, FramesWithNobodyOnOneSide) {
  // Two people of two frames are found in the second alone, and in a third
  // there are only two who are not there. TP 2, FN 2, FP 2: DetA = 2/6. Each
  // identity shares 1 of 2 + 2 - 1 frames: AssA = 1/3.
  const IdentityResult result =
      EvaluateIdentity(Make({{{0, 0}, {1, 3}}, {{0, 0}, {1, 3}}, {}}),
                       Make({{}, {{5, 0}, {6, 3}}, {{5, 0}, {6, 3}}}));
  const HotaScores hota = result.Hota();
  EXPECT_DOUBLE_EQ(hota.detection, 1.0 / 3.0);
  EXPECT_DOUBLE_EQ(hota.association, 1.0 / 3.0);
  EXPECT_DOUBLE_EQ(hota.hota, 1.0 / 3.0);
}

TEST(HotaTest, ThresholdsOfSimilarity) {
  // Always 0.25 m off: similarity 1 - 0.25 / (2 * 0.5) = 0.75, which passes the
  // fifteen thresholds 0.05 ... 0.75 and none of the four above.
  const IdentityResult result = EvaluateIdentity(
      Make({{{0, 0}}, {{0, 0}}}), Make({{{1, 0.25}}, {{1, 0.25}}}));
  EXPECT_EQ(result.hota_at[14].hota, 1.0);
  EXPECT_EQ(result.hota_at[15].hota, 0.0);
  EXPECT_DOUBLE_EQ(result.Hota().hota, 15.0 / 19.0);
  EXPECT_DOUBLE_EQ(result.hota_at[14].localisation, 0.75);
}

TEST(HotaTest, PrefersWhoGoesTogetherOverTheTake) {
  // In the last frame identity 2 is nearer, but identity 1 has been with the
  // person all along: HOTA matches 1 there, and 2 is a false positive.
  const IdentityResult result =
      EvaluateIdentity(Make({{{0, 0}}, {{0, 0}}, {{0, 0}}}),
                       Make({{{1, 0}}, {{1, 0}}, {{1, 0.25}, {2, 0.125}}}));
  const HotaScores at_half = result.hota_at[9];
  EXPECT_DOUBLE_EQ(at_half.detection, 0.75);
  EXPECT_DOUBLE_EQ(at_half.association, 1.0);
}

// ---- A truth that does not say everything

TEST(IdentityTest, PosesOnHiddenPeopleCountNeitherWay) {
  TrackSequence truth = Make({{{0, 0}}, {{0, 0}}, {{0, 0}}});
  for (Joint3d& joint : truth.frames[1].people[0].joints) {
    joint.status = JointStatus::kInferred;
  }
  // Found there, not found there, and a second pose there.
  const IdentityResult there =
      EvaluateIdentity(truth, Make({{{1, 0}}, {{1, 0}}, {{1, 0}}}));
  const IdentityResult not_there =
      EvaluateIdentity(truth, Make({{{1, 0}}, {}, {{1, 0}}}));
  for (const IdentityResult& result : {there, not_there}) {
    EXPECT_EQ(result.true_person_frames, 2);
    EXPECT_EQ(result.hidden_person_frames, 1);
    EXPECT_EQ(result.Mota(), 1.0);
    EXPECT_EQ(result.Idf1(), 1.0);
    EXPECT_EQ(result.Hota().hota, 1.0);
  }
  EXPECT_EQ(there.on_hidden_people, 1);
  EXPECT_EQ(not_there.on_hidden_people, 0);
  const IdentityResult twice =
      EvaluateIdentity(truth, Make({{{1, 0}}, {{1, 0}, {2, 0}}, {{1, 0}}}));
  EXPECT_EQ(twice.on_hidden_people, 1);
  EXPECT_EQ(twice.false_positives, 1);
}

TEST(IdentityTest, PosesBesideAPartialTruthCountNeitherWay) {
  const TrackSequence truth = Make({{{0, 0}}, {{0, 0}}});
  // Identity 2 stands where nobody is annotated, identity 3 on person 0.
  const TrackSequence found =
      Make({{{1, 0}, {2, 3}}, {{1, 0}, {2, 3}, {3, 0.25}}});
  IdentityOptions options;
  EXPECT_EQ(EvaluateIdentity(truth, found, options).false_positives, 3);
  options.annotated = Annotated::kSome;
  const IdentityResult result = EvaluateIdentity(truth, found, options);
  EXPECT_EQ(result.beside_annotations, 2);
  EXPECT_EQ(result.false_positives, 1) << "a double is one all the same";
  EXPECT_DOUBLE_EQ(result.Mota(), 0.5);
}

}  // namespace
}  // namespace kinegraph
