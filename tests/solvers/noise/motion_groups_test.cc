#include <gtest/gtest.h>

#include "core/skeleton/skeleton.h"
#include "solvers/noise/motion_level.h"

namespace kinegraph {
namespace {

int GroupOf(const MotionGroups& groups, const Skeleton& skeleton,
            const std::string& joint) {
  return groups.of_joint(skeleton.IndexOf(joint));
}

TEST(MotionGroupsTest, LimbsHaveAGroupOnEachSide) {
  const Skeleton& body = Halpe26();
  const MotionGroups groups(body);
  for (const std::string joint : {"elbow", "wrist", "knee", "ankle", "heel"}) {
    EXPECT_NE(GroupOf(groups, body, "l_" + joint),
              GroupOf(groups, body, "r_" + joint))
        << joint;
  }
  EXPECT_EQ(GroupOf(groups, body, "l_heel"),
            GroupOf(groups, body, "l_big_toe"));
  EXPECT_NE(GroupOf(groups, body, "l_elbow"), GroupOf(groups, body, "l_wrist"));
}

TEST(MotionGroupsTest, WhatMovesWithTheBodyIsOneGroupAClass) {
  const Skeleton& body = Halpe26();
  const MotionGroups groups(body);
  EXPECT_EQ(GroupOf(groups, body, "l_hip"), GroupOf(groups, body, "r_hip"));
  EXPECT_EQ(GroupOf(groups, body, "l_ear"), GroupOf(groups, body, "nose"));
  EXPECT_EQ(GroupOf(groups, body, "neck"), GroupOf(groups, body, "mid_hip"));
}

// head, trunk, shoulder, hip; elbow, wrist, knee, ankle, foot on two sides.
TEST(MotionGroupsTest, SharesOfAClassSumToOne) {
  const MotionGroups groups(Halpe26());
  ASSERT_EQ(groups.size(), 4 + 5 * 2);
  double sum = 0.0;
  for (int g = 0; g < groups.size(); ++g) sum += groups.share_of_class(g);
  EXPECT_DOUBLE_EQ(sum, 9.0);
}

}  // namespace
}  // namespace kinegraph
