// Joints under the names of other programs.
#include "core/io/text/joint_names.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/core/io/input_error.h"

namespace kinegraph {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::InputErrorOf;

TEST(JointNames, AreKnownInManySpellings) {
  for (const char* label : {"left_shoulder", "LShoulder", "shoulder_left",
                            "Shoulder L", "l_shoulder", "L_Shoulder"}) {
    EXPECT_EQ(JointNameOf(label), "l_shoulder") << label;
  }
  EXPECT_EQ(JointNameOf("left_ear"), "l_ear");
  EXPECT_EQ(JointNameOf("right_eye_inner"), "r_eye_inner");
  EXPECT_EQ(JointNameOf("mouth_right"), "r_mouth");
  EXPECT_EQ(JointNameOf("RBigToe"), "r_big_toe");
  EXPECT_EQ(JointNameOf("Hip"), "mid_hip");
  EXPECT_EQ(JointNameOf("RHip"), "r_hip");
  EXPECT_EQ(JointNameOf("snout"), "snout");
  // Written names read back, for every joint of every built-in skeleton.
  for (const std::string& name : SkeletonNames()) {
    for (const std::string& joint : FindSkeleton(name)->joints()) {
      EXPECT_EQ(JointNameOf(LongJointName(joint)), joint);
    }
  }
}

TEST(JointNames, TheExactOneWinsAndTheVaguerKeepsItsOwn) {
  EXPECT_THAT(OurJointNames({"left_foot", "left_ankle", "right_foot"}),
              ElementsAre("l_foot", "l_ankle", "r_ankle"));
  EXPECT_THAT(OurJointNames({"LHand", "LWrist", "RHand"}),
              ElementsAre("l_hand", "l_wrist", "r_wrist"));
  EXPECT_THAT(OurJointNames({"forehead", "head", "nose"}),
              ElementsAre("forehead", "head_top", "nose"));
  EXPECT_THAT(OurJointNames({"Head", "top_head", "chin", "head_bottom"}),
              ElementsAre("head", "head_top", "chin", "head_bottom"));
  EXPECT_THAT(OurJointNames({"root", "hip", "pelvis", "left_hip"}),
              ElementsAre("root", "hip", "mid_hip", "l_hip"));
  EXPECT_THAT(OurJointNames({"left_toe", "left_big_toe"}),
              ElementsAre("l_toe", "l_big_toe"));
}

TEST(JointNames, OfMarkersAreTheirOwn) {
  EXPECT_THAT(OurJointNames({"HEAD", "C7", "LTOE"}),
              ElementsAre("HEAD", "C7", "LTOE"));
}

TEST(JointNames, OfAnimalsAreTheirOwn) {
  EXPECT_THAT(OurJointNames({"nose", "head", "left_hip", "foot_l", "Tail_0"}),
              ElementsAre("nose", "head", "l_hip", "foot_l", "Tail_0"));
}

TEST(JointNames, AreAllDifferentHoweverTheyAreSpelt) {
  // Ours is the exactest spelling; what has no name left keeps its label.
  EXPECT_THAT(OurJointNames({"LAnkle", "l_ankle", "ankle_left"}),
              ElementsAre("LAnkle", "l_ankle", "ankle_left"));
  EXPECT_THAT(OurJointNames({"foot_l", "l_foot", "ankle.L"}),
              ElementsAre("foot_l", "l_foot", "l_ankle"));
  EXPECT_THAT(OurJointNames({"left_tip", "l_tip"}),
              ElementsAre("left_tip", "l_tip"));
  EXPECT_THAT(InputErrorOf([] {
                SkeletonOfLabels({"LHip", "tail", "LHip"});
              }),
              HasSubstr("joints: 'LHip' stands there twice"));
}

TEST(JointNames, OfSmplAreTheirsAndOurs) {
  EXPECT_THAT(
      OurJointNames(
          {"pelvis",        "left_hip",       "right_hip",    "spine1",
           "left_knee",     "right_knee",     "spine2",       "left_ankle",
           "right_ankle",   "spine3",         "left_foot",    "right_foot",
           "neck",          "left_collar",    "right_collar", "head",
           "left_shoulder", "right_shoulder", "left_elbow",   "right_elbow",
           "left_wrist",    "right_wrist",    "left_hand",    "right_hand"}),
      ElementsAre("mid_hip", "l_hip", "r_hip", "spine1", "l_knee", "r_knee",
                  "spine2", "l_ankle", "r_ankle", "spine3", "l_foot", "r_foot",
                  "neck", "l_collar", "r_collar", "head_top", "l_shoulder",
                  "r_shoulder", "l_elbow", "r_elbow", "l_wrist", "r_wrist",
                  "l_hand", "r_hand"));
}

TEST(JointNames, MayHaveAUnitOrASubject) {
  for (const char* label : {"LAnkle (mm)", "LAnkle [m]", "Anna:LAnkle",
                            "L.Ankle", "Left Ankle", "ankle_l", "LANKLE"}) {
    EXPECT_EQ(JointNameOf(label), "l_ankle") << label;
  }
  EXPECT_EQ(JointNameOf("Left Foot Index"), "l_foot_index");
  EXPECT_EQ(JointNameOf("LAnkle (medial)"), "LAnkle (medial)");
}

TEST(JointNames, BonesOfTheFileWin) {
  const std::vector<std::string> arm = {"left_shoulder", "left_elbow",
                                        "left_wrist"};
  const Skeleton guessed = SkeletonOfLabels(arm);
  EXPECT_EQ(guessed.bones().size(), 2u) << "an arm is a human's";
  const Skeleton stated = SkeletonOfLabels(arm, {{0, 2}}, "arm");
  EXPECT_EQ(stated.name(), "arm");
  ASSERT_EQ(stated.bones().size(), 1u);
  EXPECT_EQ(stated.bones()[0].b, 2);
  // A built-in set keeps its name, and no other may take it.
  const Skeleton known = SkeletonOfLabels(Coco17().joints(), {{0, 1}}, "x");
  EXPECT_EQ(known, Coco17());
  EXPECT_EQ(known.bones().size(), 1u);
  EXPECT_EQ(SkeletonOfLabels(arm, {}, "coco17").name(), "custom");
  EXPECT_THAT(InputErrorOf([&] {
                SkeletonOfLabels(arm, {{0, 3}});
              }),
              HasSubstr("bones: [0, 3] does not join two of the 3 joints"));
}

// As markers, "head" and "hip" must not become what others call head_top and
// mid_hip.
TEST(JointNames, AreMarkersThatReadBack) {
  const std::vector<std::string> joints = {"head_top", "head",     "mid_hip",
                                           "hip",      "l_foot",   "l_ankle",
                                           "r_toe",    "r_big_toe"};
  for (const MarkerNames names :
       {MarkerNames::kPose2Sim, MarkerNames::kOpenSim}) {
    const Skeleton markers =
        WithMarkerNames(Skeleton("mine", joints, {}), names);
    EXPECT_EQ(OurJointNames(markers.joints()), joints);
  }
}

TEST(JointNames, OfMmposesWholeBodyAreKnown) {
  std::vector<std::string> labels;
  for (const std::string& joint : WholeBody133().joints()) {
    labels.push_back(LongJointName(joint));
  }
  // MMPose's own: face-0 .. face-67, left_hand_root, left_thumb1, ...
  for (size_t i = 23; i < labels.size(); ++i) {
    labels[i] = "point-" + std::to_string(i);
  }
  EXPECT_EQ(SkeletonOfLabels(labels), WholeBody133());
  labels[22] = "right_sole";
  EXPECT_EQ(SkeletonOfLabels(labels).name(), "custom");
}

}  // namespace
}  // namespace kinegraph
