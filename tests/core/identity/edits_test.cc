#include "core/identity/edits.h"

#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

#include "core/data/identity_edit.h"
#include "tests/core/identity/crowd.h"

namespace kinegraph {
namespace {

using testing::CrowdMaker;
using testing::IdsIn;

// Person 0 in frames 0 .. 9, person 1 in 5 .. 19, person 2 in 12 .. 19.
std::vector<TrackFrame> Frames() {
  CrowdMaker crowd(20);
  crowd.Add({0, 0, 9, {-2.0, 0.0}}).Add({1, 5, 19, {2.0, 0.0}});
  crowd.Add({2, 12, 19, {-2.0, 0.0}});
  return crowd.frames();
}

IdentityEdit Edit(EditOp op, std::vector<int64_t> persons,
                  std::optional<FrameSpan> frames = std::nullopt) {
  IdentityEdit edit;
  edit.op = op;
  for (const int64_t person : persons) edit.persons.emplace_back(person);
  edit.frames = frames;
  return edit;
}

using Who = std::vector<int64_t>;

// A valid edit and the identities that some frames have after it.
struct Right {
  IdentityEdit edit;
  std::map<size_t, Who> in;  // by frame
};

TEST(ApplyEditTest, AppliesToBothEndsOfTheSpan) {
  IdentityEdit name = Edit(EditOp::kName, {0});
  name.name = "Anna";
  for (const Right& right :
       {Right{Edit(EditOp::kJoin, {0, 2}), {{15, {0, 1}}, {11, {1}}}},
        // A cut takes the next free identity.
        {Edit(EditOp::kCut, {1}, FrameSpan{8, 13}),
         {{7, {0, 1}}, {8, {0, 3}}, {13, {2, 3}}, {14, {1, 2}}}},
        {Edit(EditOp::kSwap, {0, 1}, FrameSpan{9, 10}),
         {{9, {0, 1}}, {10, {0}}, {11, {1}}}},
        {Edit(EditOp::kDelete, {1}, FrameSpan{0, 12}),
         {{9, {0}}, {12, {2}}, {13, {1, 2}}}},
        // These change no frame.
        {Edit(EditOp::kUndecided, {0, 77}), {{7, {0, 1}}}},
        {name, {{7, {0, 1}}}}}) {
    std::vector<TrackFrame> frames = Frames();
    IdentityEdit edit = right.edit;
    ASSERT_EQ(ApplyEdit(&edit, &frames), "");
    for (const auto& [frame, who] : right.in) {
      EXPECT_EQ(IdsIn(frames[frame]), who)
          << ToString(edit.op) << ", frame " << frame;
    }
    if (edit.op == EditOp::kCut) {
      EXPECT_EQ(edit.persons, (std::vector<TrackId>{TrackId(1), TrackId(3)}));
    }
    if (edit.op != EditOp::kSwap) continue;
    EXPECT_GT(frames[9].people[0].joints[0].position_m.x(), 1.0);
    EXPECT_LT(frames[9].people[1].joints[0].position_m.x(), -1.0);
  }
}

TEST(ApplyEditsTest, ReportsEditsThatDoNotApply) {
  std::vector<TrackFrame> frames = Frames();
  const IdentityEdit join = Edit(EditOp::kJoin, {0, 1}, FrameSpan{9, 12});
  const IdentityEdit gone = Edit(EditOp::kDelete, {7}, FrameSpan{0, 3});
  const IdentityEdit fits = Edit(EditOp::kDelete, {1}, FrameSpan{18, 19});
  std::vector<IdentityEdit> done;
  EXPECT_EQ(
      ApplyEdits({join, gone, fits}, &frames, &done),
      (std::vector<std::string>{
          "join 0 1, frames 9 to 12: person 0 and person 1 are both present in "
          "frame 5",
          "delete 7, frames 0 to 3: person 7 is unknown"}));
  ASSERT_EQ(done.size(), 2u);
  EXPECT_EQ(done[0].op, EditOp::kUndecided);  // a join that does not apply
  EXPECT_EQ(done[1].op, EditOp::kDelete);
  EXPECT_EQ(IdsIn(frames[7]), (Who{0, 1}));
  EXPECT_EQ(IdsIn(frames[19]), (Who{2}));
}

TEST(NamesAfterTest, JoinsCarryNamesOver) {
  IdentityEdit anna = Edit(EditOp::kName, {7});
  anna.name = "Anna";
  IdentityEdit ben = Edit(EditOp::kName, {2});
  ben.name = "Ben";
  const IdentityEdit join = Edit(EditOp::kJoin, {3, 7});
  EXPECT_EQ(NamesAfter({anna, ben, join}),
            (PersonNames{{TrackId(2), "Ben"}, {TrackId(3), "Anna"}}));
  // A person with a name keeps it; the last name given counts.
  const IdentityEdit both = Edit(EditOp::kJoin, {2, 7});
  EXPECT_EQ(NamesAfter({anna, ben, both}), (PersonNames{{TrackId(2), "Ben"}}));
  ben.name = "Bert";
  ben.persons = {TrackId(7)};
  EXPECT_EQ(NamesAfter({anna, ben}), (PersonNames{{TrackId(7), "Bert"}}));
}

// An invalid edit and a part of the reason that is reported.
struct Wrong {
  IdentityEdit edit;
  std::string message;
};

TEST(ApplyEditTest, InvalidEditsAreReportedAndChangeNothing) {
  const std::vector<Wrong> wrongs = {
      {Edit(EditOp::kJoin, {0, 7}), "person 7 is unknown"},
      {Edit(EditOp::kJoin, {0}), "persons: found 1, expected two"},
      {Edit(EditOp::kJoin, {0, 0}), "person 0 twice"},
      {Edit(EditOp::kJoin, {0, 1}), "are both present in frame 5"},
      {Edit(EditOp::kCut, {1}), "frames: missing"},
      {Edit(EditOp::kCut, {1}, FrameSpan{9, 8}), "empty range"},
      {Edit(EditOp::kCut, {1, 2}, FrameSpan{8, 9}), "exists already"},
      {Edit(EditOp::kCut, {0, 1, 2}, FrameSpan{8, 9}), "persons: found 3"},
      {Edit(EditOp::kDelete, {0}, FrameSpan{10, 19}), "person 0 is not in"},
      {Edit(EditOp::kSwap, {0, 2}, FrameSpan{10, 11}), "person 0 is not in"},
      {Edit(EditOp::kName, {0}), "name: missing"},
      {Edit(EditOp::kName, {9}), "person 9 is unknown"},
  };
  for (const Wrong& wrong : wrongs) {
    std::vector<TrackFrame> frames = Frames();
    IdentityEdit edit = wrong.edit;
    EXPECT_NE(ApplyEdit(&edit, &frames).find(wrong.message), std::string::npos)
        << wrong.message << ": " << ApplyEdit(&edit, &frames);
    const std::vector<TrackFrame> before = Frames();
    for (size_t f = 0; f < frames.size(); ++f) {
      EXPECT_EQ(IdsIn(frames[f]), IdsIn(before[f]));
    }
  }
}

}  // namespace
}  // namespace kinegraph
