#include "core/identity/linking.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/identity/edits.h"
#include "tests/core/identity/crowd.h"

namespace kinegraph {
namespace {

using testing::CrowdMaker;
using testing::IdsIn;
using testing::Walk;

struct Linked {
  std::vector<TrackFrame> frames;
  std::vector<IdentityEdit> edits;

  std::vector<IdentityEdit> Of(EditOp op) const {
    std::vector<IdentityEdit> found;
    for (const IdentityEdit& edit : edits) {
      if (edit.op == op) found.push_back(edit);
    }
    return found;
  }
};

Linked Link(std::vector<TrackFrame> frames, const LinkOptions& options = {}) {
  Linked linked;
  linked.frames = std::move(frames);
  linked.edits =
      LinkIdentities(Coco17(), testing::kCrowdRate, options, &linked.frames);
  return linked;
}

Linked Link(const CrowdMaker& crowd, const LinkOptions& options = {}) {
  return Link(crowd.frames(), options);
}

std::vector<TrackId> Ids(int64_t a, int64_t b) {
  return {TrackId(a), TrackId(b)};
}

// Two people of different size, both lost for a second at the same time. At
// constant velocity the tall one would reappear at x = -1 m and the small one
// at x = 1 m; they reappear at 1 m and 0 m.
CrowdMaker TwoHidden() {
  CrowdMaker crowd(250);
  crowd.Add({0, 0, 99, {-2.0, -1.0}, {0.6, 0.0}, 0.95})
      .Add({1, 0, 99, {2.0, 1.0}, {-0.6, 0.0}, 1.05})
      .Add({2, 125, 249, {1.0, 1.0}, {-0.6, 0.0}, 1.05})
      .Add({3, 125, 249, {0.0, -1.0}, {0.6, 0.0}, 0.95});
  return crowd;
}

TEST(LinkingTest, JoinsTwoPeopleWhoWereHidden) {
  const Linked linked = Link(TwoHidden());
  const auto joins = linked.Of(EditOp::kJoin);
  ASSERT_EQ(joins.size(), 2u);
  for (const IdentityEdit& join : joins) {
    const bool small = join.persons == Ids(0, 3);
    const bool tall = join.persons == Ids(1, 2);
    EXPECT_TRUE(small || tall)
        << join.persons[0].value() << " and " << join.persons[1].value();
    EXPECT_GE(*join.margin, LinkOptions().min_margin);
    EXPECT_EQ(join.frames->first, 99);
    EXPECT_EQ(join.frames->last, 125);
  }
  EXPECT_EQ(IdsIn(linked.frames[50]), (std::vector<int64_t>{0, 1}));
  EXPECT_EQ(IdsIn(linked.frames[110]), (std::vector<int64_t>{}));
  EXPECT_EQ(IdsIn(linked.frames[200]), (std::vector<int64_t>{0, 1}));
}

TEST(LinkingTest, ReplayedEditsReproduceTheFrames) {
  const CrowdMaker crowd = TwoHidden();
  const Linked linked = Link(crowd);
  ASSERT_FALSE(linked.edits.empty());
  std::vector<TrackFrame> replayed = crowd.frames();
  for (IdentityEdit edit : linked.edits) {
    ASSERT_EQ(ApplyEdit(&edit, &replayed), "");
  }
  for (size_t f = 0; f < replayed.size(); ++f) {
    ASSERT_EQ(IdsIn(replayed[f]), IdsIn(linked.frames[f])) << "frame " << f;
  }
  // The same recording gives the same edits.
  const Linked again = Link(crowd);
  ASSERT_EQ(again.edits.size(), linked.edits.size());
  for (size_t i = 0; i < again.edits.size(); ++i) {
    EXPECT_TRUE(SameEdit(again.edits[i], linked.edits[i]));
    EXPECT_EQ(again.edits[i].margin, linked.edits[i].margin);
  }
}

TEST(LinkingTest, PeopleVisibleAtTheSameTimeAreNotJoined) {
  // The same body, but person 0 is still there when person 1 appears.
  CrowdMaker crowd(200);
  crowd.Add({0, 0, 199, {-2.0, 0.0}, {0.0, 0.0}, 1.0})
      .Add({1, 80, 199, {2.0, 0.0}, {0.0, 0.0}, 1.0});
  const Linked linked = Link(crowd);
  EXPECT_TRUE(linked.Of(EditOp::kJoin).empty());
  EXPECT_EQ(IdsIn(linked.frames[150]), (std::vector<int64_t>{0, 1}));
}

// Two people who stand a metre apart, exchanged by the tracker at frame 150.
CrowdMaker TwoExchanged() {
  CrowdMaker crowd(300);
  crowd.Add({0, 0, 149, {-0.5, 0.0}, {0.0, 0.0}, 0.94})
      .Add({1, 0, 149, {0.5, 0.0}, {0.0, 0.0}, 1.06})
      .Add({0, 150, 299, {0.5, 0.0}, {0.0, 0.0}, 1.06})
      .Add({1, 150, 299, {-0.5, 0.0}, {0.0, 0.0}, 0.94});
  return crowd;
}

TEST(LinkingTest, SwappedIdentitiesAreSwappedBack) {
  const CrowdMaker crowd = TwoExchanged();
  const Linked linked = Link(crowd);
  const auto swaps = linked.Of(EditOp::kSwap);
  ASSERT_EQ(swaps.size(), 1u);
  EXPECT_EQ(swaps[0].frames->first, 150);
  EXPECT_EQ(swaps[0].frames->last, 299);
  EXPECT_GE(*swaps[0].margin, LinkOptions().min_margin);
  const auto x_of = [&](int64_t frame, int person) {
    return linked.frames[static_cast<size_t>(frame)]
        .people[static_cast<size_t>(person)]
        .joints[11]
        .position_m.x();
  };
  for (const int64_t frame : {10, 149, 150, 290}) {
    EXPECT_LT(x_of(frame, 0), 0.0) << frame;
    EXPECT_GT(x_of(frame, 1), 0.0) << frame;
  }
  // With more trust in the tracker, its result is kept.
  LinkOptions trusting;
  trusting.continuity = 1000.0;
  EXPECT_TRUE(Link(crowd, trusting).Of(EditOp::kSwap).empty());
}

TEST(LinkingTest, PausesOfADetectorAreNoGaps) {
  // The detector runs on every third frame; in the others no view sees anybody.
  std::vector<TrackFrame> frames = TwoExchanged().frames();
  for (TrackFrame& frame : frames) {
    for (PersonPose& person : frame.people) {
      if (frame.frame % 3 == 0) continue;
      person.inlier_views.assign(person.joints.size(), 0);
    }
  }
  const auto swaps = Link(std::move(frames)).Of(EditOp::kSwap);
  ASSERT_EQ(swaps.size(), 1u);
  EXPECT_NEAR(static_cast<double>(swaps[0].frames->first), 150.0, 3.0);
}

TEST(LinkingTest, StepBetweenFrameNumbersDoesNotMatter) {
  // Every fourth frame of the recording, numbered 0, 4, 8 or 0, 1, 2.
  const CrowdMaker crowd = TwoExchanged();
  std::vector<TrackFrame> stepped;
  for (const TrackFrame& frame : crowd.frames()) {
    if (frame.frame % 4 == 0) stepped.push_back(frame);
  }
  std::vector<TrackFrame> consecutive = stepped;
  for (TrackFrame& frame : consecutive) frame.frame /= 4;
  const Linked of_stepped = Link(std::move(stepped));
  const Linked of_consecutive = Link(std::move(consecutive));
  EXPECT_EQ(of_stepped.Of(EditOp::kSwap).size(), 1u);
  ASSERT_EQ(of_stepped.edits.size(), of_consecutive.edits.size());
  for (size_t i = 0; i < of_stepped.edits.size(); ++i) {
    EXPECT_EQ(of_stepped.edits[i].op, of_consecutive.edits[i].op);
    EXPECT_EQ(of_stepped.edits[i].persons, of_consecutive.edits[i].persons);
    EXPECT_EQ(of_stepped.edits[i].margin, of_consecutive.edits[i].margin);
  }
}

// Track 0 begins in frame `first` with the small person, is not observed for
// ten frames from `blind` on and continues on the tall one, 0.8 m away, who was
// lost in frame `lost`; the small one returns later.
CrowdMaker FoundAgainOnSomebodyElse(int64_t first, int64_t lost,
                                    int64_t blind) {
  CrowdMaker crowd(400);
  crowd.Add({0, first, blind - 1, {0.0, 0.0}, {0.0, 0.0}, 0.94})
      .Add({0, blind, blind + 9, {0.0, 0.0}, {2.0, 0.0}, 0.94, false})
      .Add({0, blind + 10, 399, {0.8, 0.0}, {0.0, 0.0}, 1.06})
      .Add({1, 0, lost - 1, {0.8, 0.0}, {0.0, 0.0}, 1.06})
      .Add({2, 250, 399, {0.0, 0.0}, {0.0, 0.0}, 0.94})
      .Add({3, 0, 399, {-3.0, -3.0}, {0.0, 0.0}, 1.0})
      .Add({4, 0, 399, {3.0, 3.0}, {0.0, 0.0}, 1.0});
  return crowd;
}

void ExpectIdentitiesToBeRestored(const Linked& linked) {
  EXPECT_EQ(linked.Of(EditOp::kCut).size(), 1u);
  EXPECT_EQ(linked.Of(EditOp::kJoin).size(), 2u);
  const std::vector<PersonPose>& people = linked.frames[390].people;
  ASSERT_EQ(people.size(), 4u);
  EXPECT_EQ(people[0].id, TrackId(0));
  // Hips are compared; the two people stand 0.8 m apart.
  EXPECT_NEAR(people[0].joints[11].position_m.x(), 0.0, 0.3);
  EXPECT_EQ(people[1].id, TrackId(1));
  EXPECT_NEAR(people[1].joints[11].position_m.x(), 0.8, 0.3);
}

TEST(LinkingTest, TrackRecoveredOnAnotherPersonIsCut) {
  ExpectIdentitiesToBeRestored(Link(FoundAgainOnSomebodyElse(0, 100, 140)));
}

TEST(LinkingTest, TrackThatMetAnotherSoonAfterItsBeginningIsCut) {
  // The tall person is lost 0.64 s after the track began next to them; then the
  // track is alone for 1.6 s, more than the second of clean frames that a piece
  // requires (kLeast, tracklet.cc).
  ExpectIdentitiesToBeRestored(Link(FoundAgainOnSomebodyElse(100, 116, 156)));
}

TEST(LinkingTest, HopSoonAfterTheBeginningIsCut) {
  // Track 0 begins with the small person, beside whom another appears; after
  // 1.7 s it is not observed and continues on the tall one, who is new. The
  // small one returns later.
  CrowdMaker crowd(300);
  crowd.Add({0, 0, 41, {0.0, 0.0}, {0.0, 0.0}, 0.94})
      .Add({0, 42, 49, {0.0, 0.0}, {3.75, 0.0}, 0.94, false})
      .Add({0, 50, 299, {1.2, 0.0}, {0.0, 0.0}, 1.06})
      .Add({1, 22, 299, {0.5, 0.6}, {0.0, 0.0}, 1.02})
      .Add({2, 90, 299, {0.1, 0.0}, {0.0, 0.0}, 0.94})
      .Add({3, 0, 299, {-3.0, -3.0}, {0.0, 0.0}, 1.0})
      .Add({4, 0, 299, {3.0, 3.0}, {0.0, 0.0}, 0.98});
  const Linked linked = Link(crowd);
  EXPECT_EQ(linked.Of(EditOp::kCut).size(), 1u);
  const std::vector<PersonPose>& people = linked.frames[250].people;
  ASSERT_EQ(people.size(), 5u);
  EXPECT_EQ(people[0].id, TrackId(0));
  EXPECT_NEAR(people[0].joints[11].position_m.x(), 0.1, 0.3);
}

TEST(LinkingTest, ShortVisitWithinAnAbsenceIsJoined) {
  // Visible for 0.4 s in the middle of an absence of eight seconds.
  CrowdMaker crowd(500);
  crowd.Add({0, 0, 149, {0.0, 0.0}, {0.0, 0.0}, 0.95})
      .Add({1, 240, 250, {0.4, 0.0}, {0.0, 0.0}, 0.95})
      .Add({2, 350, 499, {0.0, 0.4}, {0.0, 0.0}, 0.95})
      .Add({3, 0, 499, {-3.0, -3.0}, {0.0, 0.0}, 1.1})
      .Add({4, 0, 499, {3.0, 3.0}, {0.0, 0.0}, 1.04});
  const Linked linked = Link(crowd);
  EXPECT_EQ(IdsIn(linked.frames[400]), (std::vector<int64_t>{0, 3, 4}));
  EXPECT_EQ(IdsIn(linked.frames[245]), (std::vector<int64_t>{0, 3, 4}));
}

TEST(LinkingTest, PassingPeopleKeepIdentities) {
  // Two people of equal size pass each other half a metre apart: only motion
  // distinguishes them.
  CrowdMaker crowd(200);
  crowd.Add({0, 0, 199, {-4.0, -0.25}, {1.0, 0.0}, 1.0})
      .Add({1, 0, 199, {4.0, 0.25}, {-1.0, 0.0}, 1.0});
  const Linked linked = Link(crowd);
  EXPECT_TRUE(linked.edits.empty());
}

TEST(LinkingTest, ATrackThatTookOverAnotherPersonIsCut) {
  // Person 1 is lost beside person 0, whose track continues on person 1; then
  // person 0 is found again as track 2.
  CrowdMaker crowd(400);
  crowd.Add({0, 0, 199, {-0.4, 0.0}, {0.0, 0.0}, 0.94})
      .Add({1, 0, 195, {0.4, 0.0}, {0.0, 0.0}, 1.06})
      .Add({0, 200, 399, {0.4, 0.0}, {0.0, 0.0}, 1.06})
      .Add({2, 206, 399, {-0.4, 0.0}, {0.0, 0.0}, 0.94});
  const Linked linked = Link(crowd);
  ASSERT_EQ(linked.Of(EditOp::kCut).size(), 1u);
  EXPECT_EQ(linked.Of(EditOp::kJoin).size(), 2u);
  const TrackFrame& late = linked.frames[300];
  ASSERT_EQ(IdsIn(late), (std::vector<int64_t>{0, 1}));
  EXPECT_LT(late.people[0].joints[11].position_m.x(), 0.0);
  EXPECT_GT(late.people[1].joints[11].position_m.x(), 0.0);
}

TEST(LinkingTest, RepeatedVisitsAreOnePerson) {
  // Fourteen visits of 8 s, 4 s apart, while three others stay: by bones, any
  // visit may follow any earlier one, and no two are visible at the same time.
  CrowdMaker crowd(14 * 300);
  for (int visit = 0; visit < 14; ++visit) {
    crowd.Add({10 + visit,
               visit * 300,
               visit * 300 + 199,
               {-3.0, 0.0},
               {0.0, 0.0},
               1.0});
  }
  crowd.Add({0, 0, 4199, {-3.5, -3.0}, {0.0, 0.0}, 1.08})
      .Add({1, 0, 4199, {3.5, 3.0}, {0.0, 0.0}, 0.94})
      .Add({2, 0, 4199, {3.5, -3.0}, {0.0, 0.0}, 1.15});
  const Linked linked = Link(crowd);
  EXPECT_EQ(linked.Of(EditOp::kJoin).size(), 13u);
  EXPECT_TRUE(linked.Of(EditOp::kUndecided).empty());
  EXPECT_EQ(IdsIn(linked.frames[4050]), (std::vector<int64_t>{0, 1, 2, 10}));
}

TEST(LinkingTest, PeopleOfEqualSizeAreDistinguishedByMotion) {
  // Two people of equal size stand 4 m apart and are both unobserved for a
  // second.
  CrowdMaker crowd(250);
  crowd.Add({0, 0, 99, {-2.0, 0.0}, {0.0, 0.0}, 1.0})
      .Add({1, 0, 99, {2.0, 0.0}, {0.0, 0.0}, 1.0})
      .Add({2, 125, 249, {1.9, 0.1}, {0.0, 0.0}, 1.0})
      .Add({3, 125, 249, {-1.9, 0.1}, {0.0, 0.0}, 1.0});
  const Linked linked = Link(crowd);
  const auto joins = linked.Of(EditOp::kJoin);
  ASSERT_EQ(joins.size(), 2u);
  EXPECT_EQ(joins[0].persons, Ids(1, 2));
  EXPECT_EQ(joins[1].persons, Ids(0, 3));
}

TEST(LinkingTest, PossibleExchangeStaysUndecided) {
  // Two people of equal size stand half a metre apart and are both unobserved
  // for six seconds.
  CrowdMaker crowd(500);
  crowd.Add({0, 0, 99, {-0.25, 0.0}, {0.0, 0.0}, 1.0})
      .Add({1, 0, 99, {0.25, 0.0}, {0.0, 0.0}, 1.0})
      .Add({2, 250, 499, {0.0, -0.3}, {0.0, 0.0}, 1.0})
      .Add({3, 250, 499, {0.0, 0.3}, {0.0, 0.0}, 1.0});
  const Linked linked = Link(crowd);
  EXPECT_TRUE(linked.Of(EditOp::kJoin).empty());
  EXPECT_FALSE(linked.Of(EditOp::kUndecided).empty());
}

// Two people leave; after two minutes one of them appears elsewhere.
CrowdMaker OneComesBack(double size_of_other) {
  CrowdMaker crowd(3400);
  crowd.Add({0, 0, 199, {-2.0, 0.0}, {0.0, 0.0}, 1.0})
      .Add({1, 0, 199, {2.0, 0.0}, {0.0, 0.0}, size_of_other})
      .Add({2, 3200, 3399, {0.0, 2.0}, {0.0, 0.0}, 1.0});
  return crowd;
}

TEST(LinkingTest, BonesAloneJoinAfterMinutes) {
  const Linked linked = Link(OneComesBack(1.12));
  const auto joins = linked.Of(EditOp::kJoin);
  ASSERT_EQ(joins.size(), 1u);
  EXPECT_EQ(joins[0].persons, Ids(0, 2));
}

TEST(LinkingTest, EqualBonesStayUndecided) {
  const Linked linked = Link(OneComesBack(1.0));
  EXPECT_TRUE(linked.Of(EditOp::kJoin).empty());
  const auto open = linked.Of(EditOp::kUndecided);
  ASSERT_EQ(open.size(), 1u);
  EXPECT_EQ(open[0].persons[1], TrackId(2));
  EXPECT_LT(*open[0].margin, LinkOptions().min_margin);
  EXPECT_EQ(IdsIn(linked.frames[3300]), (std::vector<int64_t>{2}));
}

TEST(LinkingTest, MaximumAbsenceIsRespected) {
  LinkOptions options;
  options.max_absence_s = 60.0;
  EXPECT_TRUE(Link(OneComesBack(1.12), options).edits.empty());
}

TEST(LinkingTest, DuplicatesAreDeleted) {
  CrowdMaker crowd(200);
  crowd.Add({0, 0, 199, {0.0, 0.0}, {0.5, 0.0}, 1.0})
      .Add({1, 60, 99, {1.2 + 0.1, 0.0}, {0.5, 0.0}, 1.0});
  const Linked linked = Link(crowd);
  const auto deleted = linked.Of(EditOp::kDelete);
  ASSERT_EQ(deleted.size(), 1u);
  EXPECT_EQ(deleted[0].persons[0], TrackId(1));
  EXPECT_EQ(IdsIn(linked.frames[80]), (std::vector<int64_t>{0}));
}

TEST(LinkingTest, KnownNumberOfPeopleJoinsRemainingTracks) {
  // A person seen too briefly to be measured enters after ten seconds: no
  // evidence.
  CrowdMaker crowd(500);
  crowd.Add({0, 0, 199, {-2.0, 0.0}, {0.0, 0.0}, 1.0})
      .Add({1, 450, 451, {2.0, 0.0}, {0.0, 0.0}, 1.0});
  EXPECT_TRUE(Link(crowd).Of(EditOp::kJoin).empty());
  LinkOptions options;
  options.people = 1;
  EXPECT_EQ(Link(crowd, options).Of(EditOp::kJoin).size(), 1u);
}

// Motion and bones contradict every join; the most likely joins are made.
TEST(LinkingTest, KnownNumberOfPeopleForcesJoins) {
  CrowdMaker crowd(400);
  crowd.Add({0, 0, 199, {-2.0, 0.0}, {0.0, 0.0}, 0.9})
      .Add({1, 0, 199, {2.0, 0.0}, {0.0, 0.0}, 1.1})
      .Add({2, 210, 399, {-1.0, 0.0}, {0.0, 0.0}, 0.95})
      .Add({3, 210, 399, {0.9, 0.0}, {0.0, 0.0}, 1.05});
  EXPECT_TRUE(Link(crowd).Of(EditOp::kJoin).empty());
  LinkOptions options;
  options.people = 2;
  const Linked linked = Link(crowd, options);
  ASSERT_EQ(linked.Of(EditOp::kJoin).size(), 2u);
  for (const TrackFrame& frame :
       {linked.frames.front(), linked.frames.back()}) {
    EXPECT_EQ(IdsIn(frame), (std::vector<int64_t>{0, 1}));
    EXPECT_LT(frame.people[0].joints[0].position_m.x(), 0.0);
  }
}

// Two people are absent for a second. The entry is either far away or contains
// the positions at which both vanish and appear.
TEST(LinkingTest, VanishingAwayFromEntriesRaisesTheMargin) {
  LinkOptions options;
  options.entries = {50.0, 50.0, 1.0, 1.0};
  const Linked far = Link(TwoHidden(), options);
  options.entries = {0.0, 0.0, 1.0, 20.0};
  const Linked here = Link(TwoHidden(), options);
  ASSERT_EQ(far.Of(EditOp::kJoin).size(), 2u);
  ASSERT_EQ(here.Of(EditOp::kJoin).size(), 2u);
  // Both ends lie outside: the margin grows by twice the penalty.
  EXPECT_NEAR(*far.Of(EditOp::kJoin)[0].margin,
              *here.Of(EditOp::kJoin)[0].margin + 2.0 * options.entry_penalty,
              1e-9);
}

TEST(LinkingTest, EntriesThatAreNotSpheresAreRejected) {
  LinkOptions options;
  options.entries = {1.0, 2.0, 3.0};
  EXPECT_THROW(CheckLinkOptions(options), OptionError);
}

TEST(LinkingTest, EmptyRecordingsHaveNoEdits) {
  std::vector<TrackFrame> none;
  EXPECT_TRUE(LinkIdentities(Coco17(), 25.0, {}, &none).empty());
  std::vector<TrackFrame> empty = CrowdMaker(10).frames();
  EXPECT_TRUE(LinkIdentities(Coco17(), 25.0, {}, &empty).empty());
  EXPECT_EQ(empty.size(), 10u);
}

// Tracks of two bodies that begin and end at random times, at equal or
// different positions, some without observations.
std::vector<TrackFrame> AnyTracks(uint64_t seed) {
  constexpr int64_t kFrames = 300;
  Random random(seed);
  CrowdMaker crowd(kFrames, seed);
  const int64_t tracks = 3 + random.Index(5);
  for (int64_t id = 0; id < tracks; ++id) {
    const int64_t first = random.Index(200);
    const int64_t last = std::min(first + 20 + random.Index(100), kFrames - 1);
    const bool tall = random.Index(2) == 1;
    const double x_m = 0.1 * static_cast<double>(random.Index(8));
    const bool seen = random.Index(6) != 0;
    crowd.Add({id,
               first,
               last,
               {x_m, tall ? 1.5 : 0.0},
               {0.0, 0.0},
               tall ? 1.06 : 0.94,
               seen});
  }
  return crowd.frames();
}

TEST(LinkingTest, EditsOfRandomTracksApplyAndKeepIdentitiesUnique) {
  int changed = 0;
  for (uint64_t seed = 1; seed <= 300; ++seed) {
    std::vector<TrackFrame> frames = AnyTracks(seed);
    std::vector<std::string> left_out;
    for (const IdentityEdit& edit :
         LinkIdentities(Coco17(), 25.0, {}, &frames, &left_out)) {
      if (edit.op != EditOp::kUndecided) ++changed;
    }
    for (const std::string& line : left_out) {
      ADD_FAILURE() << "seed " << seed << ": " << line;
    }
    for (const TrackFrame& frame : frames) {
      const std::vector<int64_t> ids = testing::IdsIn(frame);
      EXPECT_EQ(std::set<int64_t>(ids.begin(), ids.end()).size(), ids.size())
          << "seed " << seed << ", frame " << frame.frame;
    }
  }
  EXPECT_GT(changed, 300);  // more than one per recording on average
}

}  // namespace
}  // namespace kinegraph
