#include "core/identity/false_positives.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/core/identity/crowd.h"

namespace kinegraph {
namespace {

using testing::CrowdMaker;

// Person 0 is there for long; 1 for `frames` frames, of that size.
std::vector<TrackId> Ghosts(double size, int64_t frames) {
  CrowdMaker crowd(100);
  crowd.Add({0, 0, 99, {-2.0, 0.0}});
  crowd.Add({1, 50, 49 + frames, {2.0, 0.0}, {0.0, 0.0}, size});
  const std::vector<TrackFrame> all = crowd.frames();
  std::vector<TrackId> removed;
  for (const IdentityEdit& edit :
       FindFalsePositives(Coco17(), 4.0, CollectTracklets(all, Coco17()))) {
    EXPECT_EQ(edit.op, EditOp::kDelete);
    EXPECT_EQ(edit.frames->first, 50);
    EXPECT_EQ(edit.frames->last, 49 + frames);
    EXPECT_GE(*edit.margin, 4.0);
    removed.push_back(edit.persons.front());
  }
  return removed;
}

TEST(FindGhostsTest, RemovesWhoHasNobodysBones) {
  const std::vector<TrackId> one = {TrackId(1)};
  EXPECT_EQ(Ghosts(1.7, 4), one);
  EXPECT_EQ(Ghosts(0.5, 4), one);
}

TEST(FindGhostsTest, KeepsBodiesHoweverShortTheyAreSeen) {
  for (const double size : {0.92, 1.0, 1.08}) {
    EXPECT_TRUE(Ghosts(size, 3).empty()) << size;
  }
}

// Somebody very tall is somebody when they stay.
TEST(FindGhostsTest, KeepsWhoStays) { EXPECT_TRUE(Ghosts(1.7, 17).empty()); }

}  // namespace
}  // namespace kinegraph
