#include "solvers/graph/outcome.h"

#include <gtest/gtest.h>

namespace kinegraph {
namespace {

TEST(StatusOf, TellsBySupportNowEverAndNear) {
  constexpr double kLimit_s = 0.5;
  struct Case {
    int inlier_views;
    bool ever_two_views;
    double nearest_support_s;
    JointStatus status;
  };
  for (const Case& one : {Case{2, true, 0.0, JointStatus::kObserved},
                          Case{1, true, 0.0, JointStatus::kInferred},
                          Case{0, true, 0.5, JointStatus::kInferred},
                          Case{0, true, 0.51, JointStatus::kMissing},
                          // One view alone never told how far away it is.
                          Case{1, false, 0.0, JointStatus::kMissing},
                          Case{0, false, 0.1, JointStatus::kMissing}}) {
    EXPECT_EQ(StatusOf(one.inlier_views, one.ever_two_views,
                       one.nearest_support_s, kLimit_s),
              one.status)
        << one.inlier_views << " " << one.ever_two_views << " "
        << one.nearest_support_s;
  }
}

TEST(JointSupport, RemembersTheLastFrameWithAView) {
  JointSupport support;
  Extend(10, 0, &support);
  EXPECT_FALSE(support.by_one_view);
  Extend(20, 1, &support);
  EXPECT_TRUE(support.by_one_view);
  EXPECT_FALSE(support.by_two_views);
  Extend(30, 2, &support);
  Extend(40, 0, &support);
  EXPECT_TRUE(support.by_two_views);
  EXPECT_EQ(support.last_time, 30);
}

}  // namespace
}  // namespace kinegraph
