// Names of joints in other programs.
#ifndef KINEGRAPH_CORE_IO_TEXT_JOINT_NAMES_H_
#define KINEGRAPH_CORE_IO_TEXT_JOINT_NAMES_H_

#include <optional>
#include <string>
#include <vector>

#include "core/skeleton/skeleton.h"

namespace kinegraph {

// kinegraph's name for a joint with a label in any spelling: "left_shoulder",
// "LShoulder", "shoulder_left" and "Shoulder L" are l_shoulder, "Hip" is
// mid_hip, "Neck" is neck, "Anna:LAnkle (mm)" is l_ankle. In the label of an
// unknown joint, only a leading "left_" or "right_" is changed, to "l_" or
// "r_".
std::string JointNameOf(const std::string& label);

// kinegraph's names for a set of labels, all distinct. If several labels may be
// the same joint, the most exact one gets its name and the others keep separate
// names: "left_ankle" and "left_foot" become l_ankle and l_foot, but "left_hip"
// and "left_foot" become l_hip and l_ankle. Inexact labels are not translated
// for animals (IsAnimalPart), nor if no label is exact, as for markers ("HEAD",
// "C7", "LTOE").
std::vector<std::string> OurJointNames(const std::vector<std::string>& labels);

// MediaPipe's name for kinegraph's: "left_shoulder" for l_shoulder,
// "mouth_left" for l_mouth; other names are unchanged.
std::string LongJointName(const std::string& joint);

// Naming convention of markers in TRC and other files.
enum class MarkerNames { kOurs, kPose2Sim, kOpenSim };
inline constexpr char kMarkerNamesList[] = "ours, pose2sim, opensim";
// nullopt for any other text.
std::optional<MarkerNames> ParseMarkerNames(const std::string& text);

// The same joints and bones under other names: kPose2Sim has "RHip", "RBigToe",
// "Head", and "Hip" (in BODY_25 "CHip"); kOpenSim has "midHip" instead, as
// OpenCap passes it to OpenSim. JointNameOf translates these names back.
Skeleton WithMarkerNames(const Skeleton& skeleton, MarkerNames names);

// The same joints and bones under kinegraph's names (OurJointNames).
Skeleton WithOurNames(const Skeleton& skeleton);

// The skeleton that a file specifies: its labels under kinegraph's names, its
// bones, and its name, or "custom" if `name` is empty or names a built-in
// skeleton. Joints that equal those of a built-in skeleton, in the same order,
// give the built-in skeleton, with the file's bones if it has any; of 133
// joints, only the first 23 must equal those of COCO-WholeBody. A human
// skeleton (IsHuman) without bones gets those of COCO-17 between its joints.
// Throws InputError "joints: ..." or "bones: ...", which does not name the
// file.
Skeleton SkeletonOfLabels(const std::vector<std::string>& labels,
                          const std::vector<Bone>& bones = {},
                          const std::string& name = "");

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TEXT_JOINT_NAMES_H_
