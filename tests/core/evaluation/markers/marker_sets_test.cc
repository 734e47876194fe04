#include "core/evaluation/markers/marker_sets.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "tests/core/evaluation/people.h"

namespace kinegraph::testing {
namespace {

using Eigen::Vector3d;
using ::testing::Contains;
using ::testing::HasSubstr;

using Markers = std::map<std::string, Vector3d>;

TrackSequence OneFrame(const Markers& markers) {
  std::vector<std::string> labels;
  Pose3d pose;
  for (const auto& [label, at_m] : markers) {
    labels.push_back(label);
    pose.push_back({at_m, JointStatus::kObserved});
  }
  return Tracks({Frame(0, {Person(0, pose)})}, Skeleton("markers", labels, {}));
}

// The joint's position in the first frame; NaN if missing.
Vector3d JointOf(const MarkerJoints& joints, const std::string& joint) {
  const int at = joints.tracks.header.skeleton.IndexOf(joint);
  EXPECT_GE(at, 0) << joint;
  if (at < 0) return Vector3d::Constant(NAN);
  const Joint3d& here =
      joints.tracks.frames[0].people[0].joints[static_cast<size_t>(at)];
  return here.present() ? here.position_m : Vector3d::Constant(NAN);
}

std::string NameOf(const std::vector<std::string>& labels) {
  const MarkerSet* set = RecogniseMarkerSet(labels);
  return set == nullptr ? "" : set->name;
}

TEST(MarkerSets, AreRecognisedByLabels) {
  EXPECT_EQ(NameOf({"LASI", "RASI", "LPSI", "RPSI", "LKNE", "LANK"}),
            "Plug-in Gait");
  EXPECT_EQ(NameOf({"Jim:LASI", "Jim:RASI", "Jim:SACR", "Jim:LTOE"}),
            "Plug-in Gait");
  EXPECT_EQ(NameOf({"LKneeOut", "LKneeIn", "RKneeOut", "RKneeIn"}),
            "Qualisys Sports");
  EXPECT_EQ(NameOf({"Q_LKneeOut", "Q_LKneeIn", "Q_RKneeOut", "Q_RKneeIn"}),
            "Qualisys Sports");
  EXPECT_EQ(NameOf({"R_FLE", "R_FME", "R_FAL", "R_TAM"}), "CAST");
  EXPECT_EQ(NameOf({"R_FLE", "R_FME", "L_IAS", "R_IAS"}), "CAST");
  EXPECT_EQ(NameOf({"RFLE", "RFME", "LIAS", "RIAS"}), "CAST");
  EXPECT_EQ(NameOf({"r_knee", "r_mknee_study", "L_mknee_study",
                    "r_mankle_study", "r.ASIS_study"}),
            "OpenCap");
  EXPECT_EQ(NameOf({"l_thigh", "l_shank", "r_thigh", "r_shank", "pelvis"}),
            "Theia3D segments");
  // Lists of joint names are not marker sets.
  EXPECT_EQ(NameOf(Coco17().joints()), "");
  EXPECT_EQ(NameOf(Body25().joints()), "");
  EXPECT_EQ(NameOf({"RHip", "RKnee", "RAnkle", "RBigToe", "RSmallToe", "RHeel",
                    "LHip", "LKnee", "LShoulder", "LElbow", "LWrist"}),
            "");
}

// Labels as listed in the documentation of each set; "*" stands for L and R.
struct Documented {
  const char* set;
  std::vector<std::string> labels;
  std::set<std::string>
      without;  // joints that the set does not define, without side
};

std::vector<Documented> DocumentedSets() {
  return {
      // Vicon: Plug-in Gait, full body.
      {"Plug-in Gait",
       {"*FHD", "*BHD", "C7",   "T10",  "CLAV", "STRN", "RBAK", "*SHO",
        "*UPA", "*ELB", "*FRM", "*WRA", "*WRB", "*FIN", "*ASI", "*PSI",
        "*THI", "*KNE", "*TIB", "*ANK", "*HEE", "*TOE"},
       {"small_toe"}},
      // Origins of segments, which a file has if Vicon's model was run on it.
      {"Plug-in Gait",
       {"*FEP", "*FEO", "*TIO", "*CLO", "*HUO", "*RAO", "*ASI", "*PSI", "*HEE",
        "*TOE"},
       {"small_toe"}},
      // Cappozzo et al. 1995, with the labels of Qualisys' module for gait.
      {"CAST",
       {"*_IAS", "*_IPS", "*_FTC", "*_FLE", "*_FME", "*_FAL", "*_TAM", "*_TTC",
        "*_FCC", "*_FM1", "*_FM2", "*_FM5", "*_SAE", "*_HLE", "*_HME", "*_USP",
        "*_RSP", "CV7", "SJN"},
       {}},
      // OpenCap: laboratory markers, and the markers that its network predicts
      // from video.
      {"OpenCap",
       {"r.ASIS", "L.ASIS", "r.PSIS", "L.PSIS", "*_knee", "*_mknee", "*_ankle",
        "*_mankle", "*_toe", "*_5meta", "*_calc", "C7", "*_Shoulder",
        "*_lelbow", "*_melbow", "*_lwrist", "*_mwrist"},
       {}},
      {"OpenCap",
       {"r.ASIS_study", "L.ASIS_study", "r.PSIS_study", "L.PSIS_study",
        "*_knee_study", "*_mknee_study", "*_ankle_study", "*_mankle_study",
        "*_toe_study", "*_5meta_study", "*_calc_study", "*_shoulder_study",
        "*_lelbow_study", "*_melbow_study", "*_lwrist_study", "*_mwrist_study",
        "*HJC_study"},
       {}}};
}

TEST(MarkerSets, DocumentedLabelListsGiveAllJoints) {
  for (const Documented& documented : DocumentedSets()) {
    Markers markers;
    for (const std::string& label : documented.labels) {
      for (const char side : {'L', 'R'}) {
        std::string sided = label;
        std::replace(sided.begin(), sided.end(), '*', side);
        const auto count = static_cast<double>(markers.size());
        markers.emplace(sided, Vector3d(std::sin(count), std::cos(3.0 * count),
                                        0.1 * count));
      }
    }
    const TrackSequence points = OneFrame(markers);
    const MarkerSet* set = RecogniseMarkerSet(points.header.skeleton.joints());
    ASSERT_NE(set, nullptr) << documented.set;
    EXPECT_EQ(set->name, documented.set);
    const MarkerJoints joints = JointsOfMarkers(points, *set);
    for (const std::string joint :
         {"hip", "knee", "ankle", "heel", "big_toe", "small_toe", "shoulder",
          "elbow", "wrist"}) {
      for (const std::string side : {"l_", "r_"}) {
        EXPECT_EQ(joints.tracks.header.skeleton.IndexOf(side + joint) >= 0,
                  documented.without.count(joint) == 0)
            << documented.set << " " << side << joint;
      }
    }
  }
}

TEST(MarkerSets, JointsAreMidpointsAndMissingIfAMarkerIs) {
  TrackSequence markers = OneFrame({{"LKneeOut", {0.0, 0.0, 0.5}},
                                    {"LKneeIn", {0.1, 0.0, 0.5}},
                                    {"LAnkleOut", {0.0, 0.0, 0.1}},
                                    {"RKneeOut", {0.4, 0.0, 0.5}},
                                    {"RKneeIn", {0.3, 0.0, 0.5}}});
  const MarkerSet& set = *RecogniseMarkerSet(markers.header.skeleton.joints());
  const MarkerJoints joints = JointsOfMarkers(markers, set);
  EXPECT_TRUE(JointOf(joints, "l_knee").isApprox(Vector3d(0.05, 0.0, 0.5)));
  EXPECT_TRUE(JointOf(joints, "r_knee").isApprox(Vector3d(0.35, 0.0, 0.5)));
  // 42 mm (kAnkleM in marker_sets.cc) inwards along the knee axis.
  EXPECT_TRUE(JointOf(joints, "l_ankle").isApprox(Vector3d(0.042, 0.0, 0.1)));
  EXPECT_THAT(joints.lacking, Contains(HasSubstr("r_ankle (")));
  const int knee = joints.tracks.header.skeleton.IndexOf("l_knee");
  const int ankle = joints.tracks.header.skeleton.IndexOf("l_ankle");
  EXPECT_TRUE(joints.is_centre[static_cast<size_t>(knee)]);
  EXPECT_FALSE(joints.is_centre[static_cast<size_t>(ankle)]);
  const int inner = markers.header.skeleton.IndexOf("LKneeIn");
  markers.frames[0].people[0].joints[static_cast<size_t>(inner)] = Joint3d{};
  EXPECT_TRUE(JointOf(JointsOfMarkers(markers, set), "l_knee").hasNaN());
}

TEST(MarkerSets, SubjectPrefixesAreIgnoredAndTwoSubjectsRefused) {
  const Markers knees = {{"Anna_LKneeOut", {0.0, 0.0, 0.5}},
                         {"Anna_LKneeIn", {0.1, 0.0, 0.5}},
                         {"Anna_RKneeOut", {0.4, 0.0, 0.5}},
                         {"Anna_RKneeIn", {0.3, 0.0, 0.5}}};
  const TrackSequence markers = OneFrame(knees);
  const MarkerSet& set = *RecogniseMarkerSet(markers.header.skeleton.joints());
  EXPECT_TRUE(JointOf(JointsOfMarkers(markers, set), "l_knee")
                  .isApprox(Vector3d(0.05, 0.0, 0.5)));
  Markers two;
  for (const char* label : {"LKneeOut", "LKneeIn", "RKneeOut", "RKneeIn"}) {
    two[std::string("Anna:") + label] = Vector3d::Zero();
    two[std::string("Ben:") + label] = Vector3d::Zero();
  }
  try {
    JointsOfMarkers(OneFrame(two), set);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("several people"));
  }
}

// A pelvis 250 mm wide and 150 mm deep, x forward, z up, y to the left.
Markers Pelvis() {
  return {{"LASI", {0.15, 0.125, 1.0}},
          {"RASI", {0.15, -0.125, 1.0}},
          {"LPSI", {0.0, 0.05, 1.0}},
          {"RPSI", {0.0, -0.05, 1.0}}};
}

JointRule HipOf(HipRule kind, const std::string& joint) {
  JointRule rule;
  rule.joint = joint;
  rule.hip = kind;
  rule.asis = {"LASI", "RASI"};
  rule.psis = {"LPSI", "RPSI"};
  return rule;
}

TEST(MarkerSets, LabelsMayDifferInLettersBeyondAscii) {
  const Vector3d left(0.0, 0.2, 0.5), right(0.0, -0.2, 0.5);
  const TrackSequence markers = OneFrame({{"膝左", left}, {"膝右", right}});
  const auto rule = [](const std::string& joint, const std::string& marker) {
    JointRule one;
    one.joint = joint;
    one.markers = {marker};
    return one;
  };
  const MarkerJoints joints = JointsOfMarkers(
      markers,
      {"knees",
       {rule("l_knee", "膝左"), rule("r_knee", "膝右"), rule("neck", "膝中")}});
  EXPECT_TRUE(JointOf(joints, "l_knee").isApprox(left));
  EXPECT_TRUE(JointOf(joints, "r_knee").isApprox(right));
  ASSERT_EQ(joints.lacking.size(), 1u);
  EXPECT_THAT(joints.lacking[0], HasSubstr("膝中"));
}

TEST(MarkerSets, RegressionHipsMatchHandComputedValues) {
  const TrackSequence markers = OneFrame(Pelvis());
  const MarkerJoints joints = JointsOfMarkers(
      markers,
      {"hips",
       {HipOf(HipRule::kHarrington, "l_hip"), HipOf(HipRule::kBell, "r_hip")}});
  // Harrington: back 0.24 * 150 + 9.9, down 0.30 * 250 + 10.9, sideways 0.33 *
  // 250 + 7.3 mm from the middle of the ASIS.
  EXPECT_TRUE(
      JointOf(joints, "l_hip")
          .isApprox(Vector3d(0.15 - 0.0459, 0.0898, 1.0 - 0.0859), 1e-9));
  // Bell: back 19 %, down 30 % and sideways 36 % of the width.
  EXPECT_TRUE(JointOf(joints, "r_hip")
                  .isApprox(Vector3d(0.15 - 0.0475, -0.09, 1.0 - 0.075), 1e-9));
}

TEST(MarkerSets, FunctionalHipIsTheCentreOfRotationOfTheThigh) {
  const Vector3d hip(0.1, 0.09, 0.91);
  TrackSequence markers;
  for (int f = 0; f < 60; ++f) {
    const double flexion = 0.5 * std::sin(0.2 * f);
    const double abduction = 0.4 * std::cos(0.31 * f);
    const Eigen::Matrix3d turn =
        (Eigen::AngleAxisd(flexion, Vector3d::UnitY()) *
         Eigen::AngleAxisd(abduction, Vector3d::UnitX()))
            .toRotationMatrix();
    Markers here = Pelvis();
    here["THI1"] = hip + turn * Vector3d(0.05, 0.05, -0.2);
    here["THI2"] = hip + turn * Vector3d(0.0, 0.06, -0.38);
    TrackSequence one = OneFrame(here);
    one.frames[0].frame = f;
    if (f == 0) markers.header = one.header;
    markers.frames.push_back(one.frames[0]);
  }
  JointRule rule = HipOf(HipRule::kFunctional, "l_hip");
  rule.markers = {"THI1", "THI2"};
  const MarkerSet set = {"functional", {rule}};
  EXPECT_TRUE(
      JointOf(JointsOfMarkers(markers, set), "l_hip").isApprox(hip, 1e-9));
  // A person who stands still does not determine the centre.
  for (TrackFrame& frame : markers.frames) {
    frame.people = markers.frames[0].people;
  }
  EXPECT_THROW(JointsOfMarkers(markers, set), InputError);
}

}  // namespace
}  // namespace kinegraph::testing
