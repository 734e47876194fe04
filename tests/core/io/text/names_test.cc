// Names of files, of views, and of joints in other programs.
#include "core/io/text/names.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "core/io/text/joint_names.h"
#include "tests/core/io/input_error.h"

namespace kinegraph {
namespace {

using ::testing::ElementsAre;
using testing::ExpectInputError;

TEST(LastInteger, ReturnsTheLastRunOfDigits) {
  EXPECT_EQ(LastInteger("cam01_json"), 1);
  EXPECT_EQ(LastInteger("00_16"), 16);
  EXPECT_EQ(LastInteger("Camera0"), 0);
  EXPECT_EQ(LastInteger("left"), std::nullopt);
  EXPECT_EQ(LastInteger(""), std::nullopt);
  EXPECT_EQ(LastInteger("a000000000000000000000000000012"), 12);
  EXPECT_EQ(LastInteger("a1234567890123456789"), std::nullopt);
}

TEST(FrameOfFileName, IsTheLastIntegerBeforeKeypointsOrTheExtension) {
  EXPECT_EQ(FrameOfFileName("cam0_000000000300_keypoints.json"), 300);
  EXPECT_EQ(FrameOfFileName("cam01.0042.json"), 42);
  EXPECT_EQ(FrameOfFileName("take_7_keypoints_v2.json"), 7);
  EXPECT_EQ(FrameOfFileName("body3DScene_00010600.json"), 10600);
  EXPECT_EQ(FrameOfFileName("meta.json"), std::nullopt);
}

TEST(NaturalLess, ComparesNumbersAsNumbers) {
  EXPECT_TRUE(NaturalLess("cam2", "cam10"));
  EXPECT_FALSE(NaturalLess("cam10", "cam2"));
  EXPECT_TRUE(NaturalLess("_3", "_16"));
  EXPECT_TRUE(NaturalLess("a", "b"));
  EXPECT_TRUE(NaturalLess("cam", "cam0"));
  EXPECT_FALSE(NaturalLess("cam1", "cam1"));
  // A strict order: of names that differ only in leading zeros, one precedes
  // the other.
  EXPECT_NE(NaturalLess("cam1", "cam01"), NaturalLess("cam01", "cam1"));
  EXPECT_TRUE(NaturalLess("1_01_b", "01_1_c"));
}

TEST(JointNames, AreRecognisedInManySpellings) {
  for (const auto& [label, joint] : {std::pair{"left_shoulder", "l_shoulder"},
                                     {"LShoulder", "l_shoulder"},
                                     {"shoulder_left", "l_shoulder"},
                                     {"Shoulder L", "l_shoulder"},
                                     {"l_shoulder", "l_shoulder"},
                                     {"L_Shoulder", "l_shoulder"},
                                     {"left_ear", "l_ear"},
                                     {"right_eye_inner", "r_eye_inner"},
                                     {"mouth_right", "r_mouth"},
                                     {"RBigToe", "r_big_toe"},
                                     {"Hip", "mid_hip"},
                                     {"RHip", "r_hip"},
                                     {"snout", "snout"},
                                     {"rear", "rear"},
                                     {"Rear (mm)", "Rear (mm)"},
                                     {"box:rear [m]", "box:rear [m]"},
                                     {"REar", "r_ear"},
                                     {"R ear", "r_ear"},
                                     {"r_ear", "r_ear"},
                                     // With a unit or a subject, and other
                                     // spellings.
                                     {"LAnkle (mm)", "l_ankle"},
                                     {"LAnkle [m]", "l_ankle"},
                                     {"Anna:LAnkle", "l_ankle"},
                                     {"L.Ankle", "l_ankle"},
                                     {"Left Ankle", "l_ankle"},
                                     {"ankle_l", "l_ankle"},
                                     {"LANKLE", "l_ankle"},
                                     {"Left Foot Index", "l_foot_index"},
                                     {"LAnkle (medial)", "LAnkle (medial)"}}) {
    EXPECT_EQ(JointNameOf(label), joint) << label;
  }
  // Written names are read back, for every joint of every built-in skeleton.
  for (const std::string& name : SkeletonNames()) {
    for (const std::string& joint : FindSkeleton(name)->joints()) {
      EXPECT_EQ(JointNameOf(LongJointName(joint)), joint);
    }
  }
}

TEST(JointNames, AreUniqueForAllSpellings) {
  using Names = std::vector<std::string>;
  for (const auto& [labels, joints] : std::vector<std::pair<Names, Names>>{
           // The exact label gets the joint, less exact ones keep their names.
           {{"left_foot", "left_ankle", "right_foot"},
            {"l_foot", "l_ankle", "r_ankle"}},
           {{"LHand", "LWrist", "RHand"}, {"l_hand", "l_wrist", "r_wrist"}},
           {{"forehead", "head", "nose"}, {"forehead", "head_top", "nose"}},
           {{"Head", "top_head", "chin", "head_bottom"},
            {"head", "head_top", "chin", "head_bottom"}},
           {{"root", "hip", "pelvis", "left_hip"},
            {"root", "hip", "mid_hip", "l_hip"}},
           {{"left_toe", "left_big_toe"}, {"l_toe", "l_big_toe"}},
           // "rear" is the back of a box, and the right ear of an animal with a
           // left one.
           {{"front", "Rear"}, {"front", "Rear"}},
           {{"front (mm)", "Rear (mm)"}, {"front (mm)", "Rear (mm)"}},
           {{"nose", "lear", "rear"}, {"nose", "l_ear", "r_ear"}},
           {{"lear (mm)", "rear (mm)"}, {"l_ear", "r_ear"}},
           {{"leftear", "rightear", "rear"}, {"l_ear", "r_ear", "rear"}},
           // Markers, and parts of animals.
           {{"HEAD", "C7", "LTOE"}, {"HEAD", "C7", "LTOE"}},
           {{"nose", "head", "left_hip", "foot_l", "Tail_0"},
            {"nose", "head", "l_hip", "foot_l", "Tail_0"}},
           // kinegraph's spelling is the most exact; labels without a free
           // name are kept.
           {{"LAnkle", "l_ankle", "ankle_left"},
            {"LAnkle", "l_ankle", "ankle_left"}},
           {{"foot_l", "l_foot", "ankle.L"}, {"foot_l", "l_foot", "l_ankle"}},
           {{"left_tip", "l_tip"}, {"left_tip", "l_tip"}}}) {
    EXPECT_EQ(OurJointNames(labels), joints);
  }
  ExpectInputError(
      [] {
        SkeletonOfLabels({"LHip", "tail", "LHip"});
      },
      "joints: 'LHip' appears twice");
}

TEST(JointNames, SmplNamesAreRecognised) {
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

TEST(JointNames, BonesOfTheFileHavePrecedence) {
  const std::vector<std::string> arm = {"left_shoulder", "left_elbow",
                                        "left_wrist"};
  const Skeleton guessed = SkeletonOfLabels(arm);
  EXPECT_EQ(guessed.bones().size(), 2u) << "an arm identifies a human";
  const Skeleton stated = SkeletonOfLabels(arm, {{0, 2}}, "arm");
  EXPECT_EQ(stated.name(), "arm");
  ASSERT_EQ(stated.bones().size(), 1u);
  EXPECT_EQ(stated.bones()[0].b, 2);
  // A built-in set of joints keeps its name; other sets cannot have this name.
  const Skeleton known = SkeletonOfLabels(Coco17().joints(), {{0, 1}}, "x");
  EXPECT_EQ(known, Coco17());
  EXPECT_EQ(known.bones().size(), 1u);
  EXPECT_EQ(SkeletonOfLabels(arm, {}, "coco17").name(), "custom");
  ExpectInputError(
      [&] {
        SkeletonOfLabels(arm, {{0, 3}});
      },
      "bones: [0, 3] does not join two of the 3 joints");
}

// The markers of the joints "head" and "hip" must not be read back as head_top
// and mid_hip if the skeleton has these joints, too.
TEST(JointNames, MarkerNamesAreReadBack) {
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

TEST(JointNames, MmposeWholeBodyIsRecognised) {
  std::vector<std::string> labels;
  for (const std::string& joint : WholeBody133().joints()) {
    labels.push_back(LongJointName(joint));
  }
  // MMPose has other names for the points of face and hands (face-0,
  // left_hand_root, ...); any names are accepted there.
  for (size_t i = 23; i < labels.size(); ++i) {
    labels[i] = "point-" + std::to_string(i);
  }
  EXPECT_EQ(SkeletonOfLabels(labels), WholeBody133());
  labels[22] = "right_sole";
  EXPECT_EQ(SkeletonOfLabels(labels).name(), "custom");
}

}  // namespace
}  // namespace kinegraph
