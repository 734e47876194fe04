#include "core/skeleton/skeleton.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/base/error.h"

namespace kinegraph {
namespace {

TEST(SkeletonTest, BuiltInOnesHaveTheirPublishedOrder) {
  EXPECT_EQ(Coco17().joint_count(), 17);
  EXPECT_EQ(Coco17().IndexOf("r_ankle"), 16);
  EXPECT_EQ(Body25().joint_count(), 25);
  EXPECT_EQ(Body25().IndexOf("neck"), 1);
  EXPECT_EQ(Body25().IndexOf("r_heel"), 24);
  EXPECT_EQ(Body25B().IndexOf("head_top"), 18);
  EXPECT_EQ(Tum14().IndexOf("head_bottom"), 12);
  EXPECT_EQ(Panoptic19().IndexOf("r_ear"), 18);
  EXPECT_EQ(FourDA19().IndexOf("neck"), 1);
  for (const std::string& name : SkeletonNames()) {
    ASSERT_NE(FindSkeleton(name), nullptr);
    EXPECT_EQ(FindSkeleton(name)->name(), name);
    EXPECT_FALSE(FindSkeleton(name)->bones().empty());
  }
  EXPECT_EQ(FindSkeleton("coco18x"), nullptr);
}

TEST(SkeletonTest, Body25ToCoco17IsThePublishedMap) {
  // data/shelf/reference/README.md: BODY_25 column of each COCO joint.
  EXPECT_EQ(MapByName(Body25(), Coco17()),
            (std::vector<int>{0, 16, 15, 18, 17, 5, 2, 6, 3, 7, 4, 12, 9, 13,
                              10, 14, 11}));
}

TEST(SkeletonTest, MirrorsFollowNames) {
  const Skeleton& coco = Coco17();
  EXPECT_EQ(coco.mirror(coco.IndexOf("l_wrist")), coco.IndexOf("r_wrist"));
  EXPECT_EQ(coco.mirror(0), 0) << "the nose is its own mirror";
  for (int j = 0; j < coco.joint_count(); ++j) {
    EXPECT_EQ(coco.mirror(coco.mirror(j)), j);
  }
}

TEST(SkeletonTest, FeetAndHandsDoNotAssociate) {
  EXPECT_EQ(Body25().association_joints().size(), 17u);
  EXPECT_EQ(Tum14().association_joints().size(), 12u);
  const Skeleton hand("hand", {"thumb", "index", "ring"}, {{0, 1}});
  EXPECT_EQ(hand.association_joints(), (std::vector<int>{0, 1, 2}));
}

TEST(SkeletonTest, RefusesWhatIsNoSkeleton) {
  EXPECT_THROW(Skeleton("x", {}, {}), OptionError);
  EXPECT_THROW(Skeleton("x", {"a", "a"}, {}), OptionError);
  EXPECT_THROW(Skeleton("x", {"a", ""}, {}), OptionError);
  EXPECT_THROW(Skeleton("x", {"a", "b"}, {{0, 2}}), OptionError);
  EXPECT_THROW(Skeleton("x", {"a", "b"}, {{1, 1}}), OptionError);
}

TEST(SkeletonTest, JointCountsOf17AreSharesRoundedUp) {
  EXPECT_EQ(ScaledJoints(11.0, 17), 11);
  EXPECT_EQ(ScaledJoints(10.0, 17), 10);
  EXPECT_EQ(ScaledJoints(11.0, 12), 8);  // 7.76
  EXPECT_EQ(ScaledJoints(6.0, 5), 2);    // 1.76
  EXPECT_EQ(ScaledJoints(0.0, 17), 0);
}

}  // namespace
}  // namespace kinegraph
