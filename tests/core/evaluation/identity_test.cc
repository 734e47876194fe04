#include "core/evaluation/identity.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>

#include "tests/core/evaluation/people.h"

namespace kinegraph::testing {
namespace {

IdentityResult Evaluate(const std::string& truth, const std::string& found) {
  return EvaluateIdentity(Standing(truth), Standing(found));
}

constexpr char kFour[] = "0@0 | 0@0 | 0@0 | 0@0";

struct Case {
  const char* truth;
  const char* found;
  // Matches, misses, false positives, switches, fragments, true positives of
  // identities.
  std::array<int64_t, 6> counts;
  double mota, idf1;
};

TEST(IdentityTest, CountsMatchHandComputedValues) {
  for (const Case& c : {
           Case{"0@0 1@3 | 0@0", "7@.25 5@3 | 7@0", {3, 0, 0, 0, 0, 3}, 1, 1},
           // A switch in the middle, and two people swapped.
           Case{kFour, "1@0 | 1@0 | 2@0 | 2@0", {4, 0, 0, 1, 0, 2}, .75, .5},
           Case{"0@0 1@3 | 0@0 1@3",
                "4@0 5@3 | 5@0 4@3",
                {4, 0, 0, 2, 0, 2},
                .5,
                .5},
           // A gap counts as a fragment only if the person is found again.
           Case{kFour, "1@0 | | 1@0 |", {2, 2, 0, 0, 1, 2}, .5, 2. / 3},
           Case{"0@0 | 0@0 | 0@0",
                "1@0 | | 2@0",
                {2, 1, 0, 1, 1, 1},
                1. / 3,
                .4},
           // A match persists although another identity comes nearer.
           Case{"0@0 | 0@0", "1@.25 | 1@.25 2@0", {2, 0, 1, 0, 0, 2}, .5, .8},
           // A frame missing in the truth, and one without people.
           Case{"0@0", "1@0 | 1@0", {1, 0, 0, 0, 0, 1}, 1, 1},
           Case{"0@0 |", "1@0 | 1@0", {1, 0, 1, 0, 0, 1}, 0, 2. / 3},
           // The gate includes its limit.
           Case{"0@0", "1@0.5", {1, 0, 0, 0, 0, 1}, 1, 1},
           Case{"0@0", "1@0.5625", {0, 1, 1, 0, 0, 0}, -1, 0},
           // Identity 1 explains person 0 for two frames and person 1 for one;
           // identity 2 explains person 0 once. The pair (0, 1) leaves nothing
           // for person 1, but explains two frames, as do (0, 2) and (1, 1)
           // together.
           Case{"0@0 | 0@0 | 0@0 | 1@3",
                "1@0 | 1@0 | 2@0 | 1@3",
                {4, 0, 0, 1, 0, 2},
                .75,
                .5},
           // Identity 7 moves from person 0 to person 1, and then 0 comes near
           // it, too: 7 stays with 1, independent of the order of the truth.
           Case{"0@0 1@3 | 0@0 1@3 | 0@2.7 1@3",
                "7@0 | 7@3 | 7@3 8@2.4",
                {4, 2, 0, 1, 1, 3},
                .5,
                .6},
           Case{"1@3 0@0 | 1@3 0@0 | 1@3 0@2.7",
                "7@0 | 7@3 | 7@3 8@2.4",
                {4, 2, 0, 1, 1, 3},
                .5,
                .6},
       }) {
    SCOPED_TRACE(std::string(c.truth) + " and " + c.found);
    const IdentityResult r = Evaluate(c.truth, c.found);
    EXPECT_EQ((std::array<int64_t, 6>{r.matches, r.misses, r.false_positives,
                                      r.switches, r.fragments,
                                      r.identity_true_positives}),
              c.counts);
    EXPECT_DOUBLE_EQ(r.Mota(), c.mota);
    EXPECT_DOUBLE_EQ(r.Idf1(), c.idf1);
  }
  const IdentityResult people = Evaluate("0@0 1@3 | 0@0", "7@0 5@3 | 6@0");
  EXPECT_EQ(people.true_people, 2);
  EXPECT_EQ(people.identities, 3);
}

TEST(IdentityTest, NoPeopleGiveNaN) {
  const IdentityResult result = Evaluate("", "");
  EXPECT_TRUE(std::isnan(result.Mota()));
  EXPECT_TRUE(std::isnan(result.Idf1()));
  EXPECT_TRUE(std::isnan(result.Hota().hota));
}

TEST(HotaTest, ScoresMatchHandComputedValues) {
  const auto expect = [](const char* truth, const char* found, double detection,
                         double association) {
    SCOPED_TRACE(found);
    const HotaScores hota = Evaluate(truth, found).Hota();
    EXPECT_DOUBLE_EQ(hota.detection, detection);
    EXPECT_DOUBLE_EQ(hota.association, association);
    EXPECT_DOUBLE_EQ(hota.hota, std::sqrt(detection * association));
    EXPECT_DOUBLE_EQ(hota.localisation, 1.0);
  };
  // Every pose is matched. Each identity shares 2 of 4 + 2 - 2 frames, so each
  // match counts a half.
  expect(kFour, "1@0 | 1@0 | 2@0 | 2@0", 1.0, 0.5);
  // TP 2, FN 2, FP 1. Identity 1 shares 2 of 4 + 2 - 2 frames.
  expect(kFour, "1@0 | 1@0 | | 9@3", 0.4, 0.5);
  // Two people in two frames are found in the second only, and a third frame
  // has two false poses. TP 2, FN 2, FP 2. Each identity shares 1 of 2 + 2 - 1
  // frames.
  expect("0@0 1@3 | 0@0 1@3 |", "| 5@0 6@3 | 5@0 6@3", 1.0 / 3.0, 1.0 / 3.0);
}

TEST(HotaTest, PosesPassThresholdsUpToTheirSimilarity) {
  // The error is always 0.25 m: similarity 1 - 0.25 / (2 * 0.5) = 0.75, which
  // passes the fifteen thresholds 0.05 ... 0.75 and none of the four above.
  const IdentityResult result = Evaluate("0@0 | 0@0", "1@0.25 | 1@0.25");
  EXPECT_EQ(result.hota_at[14].hota, 1.0);
  EXPECT_EQ(result.hota_at[15].hota, 0.0);
  EXPECT_DOUBLE_EQ(result.Hota().hota, 15.0 / 19.0);
  EXPECT_DOUBLE_EQ(result.hota_at[14].localisation, 0.75);
}

TEST(HotaTest, MatchesByAgreementOverTheRecording) {
  // In the last frame identity 2 is nearer, but identity 1 corresponds to the
  // person over the recording: HOTA matches 1, and 2 is a false positive.
  const IdentityResult result =
      Evaluate("0@0 | 0@0 | 0@0", "1@0 | 1@0 | 1@0.25 2@0.125");
  EXPECT_DOUBLE_EQ(result.hota_at[9].detection, 0.75);
  EXPECT_DOUBLE_EQ(result.hota_at[9].association, 1.0);
}

// ---- An incomplete truth

TEST(IdentityTest, PosesOnHiddenPeopleAreNoFalsePositives) {
  TrackSequence truth = Standing("0@0 | 0@0 | 0@0");
  for (Joint3d& joint : truth.frames[1].people[0].joints) {
    joint.status = JointStatus::kInferred;
  }
  // The hidden person is found, not found, or found twice: only the second of
  // two poses is a false positive.
  for (const char* found :
       {"1@0 | 1@0 | 1@0", "1@0 | | 1@0", "1@0 | 1@0 2@0 | 1@0"}) {
    SCOPED_TRACE(found);
    const IdentityResult result = EvaluateIdentity(truth, Standing(found));
    const bool twice = std::string(found).find('2') != std::string::npos;
    EXPECT_EQ(result.true_person_frames, 2);
    EXPECT_EQ(result.hidden_person_frames, 1);
    EXPECT_EQ(result.on_hidden_people,
              std::string(found) == "1@0 | | 1@0" ? 0 : 1);
    EXPECT_EQ(result.false_positives, twice ? 1 : 0);
    EXPECT_EQ(result.Mota(), twice ? 0.5 : 1.0);
    EXPECT_EQ(result.Hota().hota == 1.0, !twice);
  }
}

TEST(IdentityTest, PosesBesideAPartialTruthAreNoFalsePositives) {
  const TrackSequence truth = Standing("0@0 | 0@0");
  // Identity 2 is far from all annotations, identity 3 is near person 0.
  const TrackSequence found = Standing("1@0 2@3 | 1@0 2@3 3@0.25");
  IdentityOptions options;
  EXPECT_EQ(EvaluateIdentity(truth, found, options).false_positives, 3);
  options.annotated = Annotated::kSome;
  const IdentityResult result = EvaluateIdentity(truth, found, options);
  EXPECT_EQ(result.beside_annotations, 2);
  EXPECT_EQ(result.false_positives, 1)
      << "a second pose on a person is a false positive";
  EXPECT_DOUBLE_EQ(result.Mota(), 0.5);
}

}  // namespace
}  // namespace kinegraph::testing
