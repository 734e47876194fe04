#include "core/skeleton/skeleton.h"

#include <gtest/gtest.h>

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/skeleton/body_joints.h"

namespace kinegraph {
namespace {

TEST(SkeletonTest, BuiltInSkeletonsHaveThePublishedOrder) {
  struct Place {
    const Skeleton* skeleton;
    int joints;
    std::map<std::string, int> at;
  };
  for (const Place& one : {Place{&Coco17(), 17, {{"r_ankle", 16}}},
                           {&Body25(), 25, {{"neck", 1}, {"r_heel", 24}}},
                           {&Body25B(), 25, {{"head_top", 18}}},
                           {&Tum14(), 14, {{"head_bottom", 12}}},
                           {&Panoptic19(), 19, {{"r_ear", 18}}},
                           {&FourDA19(), 19, {{"neck", 1}}},
                           {&Halpe26(),
                            26,
                            {{"head_top", 17},
                             {"mid_hip", 19},
                             {"r_big_toe", 21},
                             {"r_heel", 25}}},
                           {&MediaPipe33(),
                            33,
                            {{"r_ear", 8},
                             {"l_shoulder", 11},
                             {"r_thumb", 22},
                             {"r_foot_index", 32}}},
                           {&WholeBody133(),
                            133,
                            {{"l_heel", 19},
                             {"face_8", 31},
                             {"l_hand_0", 91},
                             {"r_hand_20", 132}}}}) {
    EXPECT_EQ(one.skeleton->joint_count(), one.joints);
    for (const auto& [joint, index] : one.at) {
      EXPECT_EQ(one.skeleton->IndexOf(joint), index) << joint;
    }
  }
  for (const auto& [name, skeleton] : std::map<std::string, const Skeleton*>{
           {"coco17", &Coco17()},
           {"body25", &Body25()},
           {"body25b", &Body25B()},
           {"halpe26", &Halpe26()},
           {"mediapipe33", &MediaPipe33()},
           {"coco18", &Coco18()},
           {"tum14", &Tum14()},
           {"tum15", &Tum15()},
           {"panoptic15", &Panoptic15()},
           {"panoptic19", &Panoptic19()},
           {"4da19", &FourDA19()},
           {"wholebody133", &WholeBody133()}}) {
    EXPECT_EQ(skeleton->name(), name);
  }
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

// Pairs of iBUG's 68 points as COCO-WholeBody lists them for flipped images.
TEST(SkeletonTest, FacesMirror) {
  const Skeleton& body = WholeBody133();
  const int face = 23;
  for (const auto& [a, b] : {std::pair{0, 16},
                             {17, 26},
                             {31, 35},
                             {36, 45},
                             {38, 43},
                             {39, 42},
                             {40, 47},
                             {41, 46},
                             {48, 54},
                             {55, 59},
                             {60, 64},
                             {65, 67}}) {
    EXPECT_EQ(body.mirror(face + a), face + b) << a;
    EXPECT_EQ(body.joints()[face + a][2], 'f') << a;
  }
  for (const int central : {8, 27, 30, 33, 51, 57, 62, 66}) {
    EXPECT_EQ(body.mirror(face + central), face + central);
  }
  // The lower lip runs from the person's left to the right.
  EXPECT_EQ(body.joints()[face + 55].substr(0, 2), "l_");
  EXPECT_EQ(body.joints()[face + 36].substr(0, 2), "r_");
}

TEST(SkeletonTest, JointsHaveMirrorsAndClasses) {
  for (const std::string& name : SkeletonNames()) {
    const Skeleton& skeleton = *FindSkeleton(name);
    for (int j = 0; j < skeleton.joint_count(); ++j) {
      const std::string& joint = skeleton.joints()[j];
      EXPECT_EQ(skeleton.mirror(skeleton.mirror(j)), j) << name << " " << joint;
      const bool sided = joint[1] == '_';
      EXPECT_EQ(skeleton.mirror(j) != j, sided) << name << " " << joint;
      const bool hand = joint.find("hand_") != std::string::npos ||
                        joint.find("pinky") != std::string::npos ||
                        joint.find("index") == 2 ||
                        joint.find("thumb") != std::string::npos;
      EXPECT_EQ(skeleton.joint_class(j) == JointClass::kOther, hand)
          << name << " " << joint;
    }
  }
}

TEST(SkeletonTest, AreFoundByJointsAndBySize) {
  EXPECT_EQ(FindSkeletonOf(Body25B().joints()), &Body25B());
  EXPECT_EQ(FindSkeletonOf({"nose"}), nullptr);
  EXPECT_EQ(SkeletonsOfSize(25),
            (std::vector<const Skeleton*>{&Body25(), &Body25B()}));
  EXPECT_TRUE(SkeletonsOfSize(24).empty());
}

TEST(SkeletonTest, FeetAndHandsAreNoAssociationJoints) {
  EXPECT_EQ(Body25().association_joints().size(), 17u);
  EXPECT_EQ(Halpe26().association_joints().size(), 17u);
  EXPECT_EQ(MediaPipe33().association_joints().size(), 17u);
  EXPECT_EQ(WholeBody133().association_joints().size(), 17u);
  EXPECT_EQ(Tum14().association_joints().size(), 12u);
  const Skeleton hand("hand", {"thumb", "index", "ring"}, {{0, 1}});
  EXPECT_EQ(hand.association_joints(), (std::vector<int>{0, 1, 2}));
}

TEST(SkeletonTest, HumansHaveALimbAndNoTail) {
  for (const std::string& name : SkeletonNames()) {
    EXPECT_TRUE(IsHuman(*FindSkeleton(name))) << name;
  }
  const std::vector<std::string> leg = {"l_hip", "l_knee", "l_ankle"};
  const auto is_human = [](std::vector<std::string> joints,
                           const std::string& more) {
    if (!more.empty()) joints.push_back(more);
    return IsHuman(Skeleton("x", joints, {}));
  };
  EXPECT_TRUE(is_human(leg, ""));
  EXPECT_TRUE(is_human(leg, "ponytail"));
  for (const char* part : {"tail", "TailBase", "TAILTIP", "root of tail",
                           "ForepawL", "l_hind_hoof", "Snout", "wing_l"}) {
    EXPECT_FALSE(is_human(leg, part)) << part;
  }
  EXPECT_FALSE(is_human({"l_hip", "l_knee", "r_hip", "r_knee"}, "spine"));
}

// A mouse shares twelve names with COCO-17.
TEST(SkeletonTest, AllJointsOfAnAnimalAreAssociationJoints) {
  std::vector<std::string> joints = {"snout", "tail_base"};
  for (const std::string side : {"l_", "r_"}) {
    for (const char* part :
         {"ear", "shoulder", "elbow", "wrist", "knee", "ankle"}) {
      joints.push_back(side + part);
    }
  }
  EXPECT_EQ(Skeleton("mouse", joints, {}).association_joints().size(), 14u);
  joints[0] = "nose";
  joints[1] = "neck";
  EXPECT_EQ(Skeleton("human", joints, {}).association_joints().size(), 13u);
}

TEST(SkeletonTest, RefusesInvalidJointsAndBones) {
  EXPECT_THROW(Skeleton("x", {}, {}), OptionError);
  EXPECT_THROW(Skeleton("x", {"a", "a"}, {}), OptionError);
  EXPECT_THROW(Skeleton("x", {"a", ""}, {}), OptionError);
  EXPECT_THROW(Skeleton("x", {"a", "b"}, {{0, 2}}), OptionError);
  EXPECT_THROW(Skeleton("x", {"a", "b"}, {{1, 1}}), OptionError);
}

TEST(SkeletonTest, ThresholdsOf17JointsScaleRoundedUp) {
  EXPECT_EQ(ScaledJoints(11.0, 17), 11);
  EXPECT_EQ(ScaledJoints(10.0, 17), 10);
  EXPECT_EQ(ScaledJoints(11.0, 12), 8);  // 7.76
  EXPECT_EQ(ScaledJoints(6.0, 5), 2);    // 1.76
  EXPECT_EQ(ScaledJoints(0.0, 17), 0);
}

}  // namespace
}  // namespace kinegraph
