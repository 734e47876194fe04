// Names of joints in other programs.
#ifndef KINEGRAPH_CORE_IO_TEXT_JOINT_NAMES_H_
#define KINEGRAPH_CORE_IO_TEXT_JOINT_NAMES_H_

#include <optional>
#include <string>
#include <vector>

#include "core/skeleton/skeleton.h"

namespace kinegraph {

// Our name for a detector's joint, in any spelling: "left_shoulder",
// "LShoulder", "shoulder_left" and "Shoulder L" are l_shoulder, "Hip" is
// mid_hip, "Neck" neck, "Anna:LAnkle (mm)" l_ankle. A label of no known joint
// is returned unchanged.
std::string JointNameOf(const std::string& label);

// Our names for a set of labels, all distinct. Of several that may be one joint
// the most exact becomes it, the others keep separate names ("left_ankle"
// and "left_foot" are l_ankle and l_foot; "left_hip" and "left_foot" l_hip and
// l_ankle). Inexact names are not used where no label is exact, as for markers
// ("HEAD", "C7", "LTOE"), nor for animals (IsAnimalPart).
std::vector<std::string> OurJointNames(const std::vector<std::string>& labels);

// The reverse: "left_shoulder" for l_shoulder, "mouth_left" for l_mouth, as
// MediaPipe writes them; other names unchanged.
std::string LongJointName(const std::string& joint);

// Naming convention of markers in TRC and other files.
enum class MarkerNames { kOurs, kPose2Sim, kOpenSim };
inline constexpr char kMarkerNamesList[] = "ours, pose2sim, opensim";
// nullopt for any other text.
std::optional<MarkerNames> ParseMarkerNames(const std::string& text);

// The same joints and bones under other names: Pose2Sim's "RHip", "RBigToe",
// "Head", "Hip" or, in BODY_25, "CHip"; `kOpenSim` the same but "midHip", as
// OpenCap passes them to OpenSim. JointNameOf reads all of them back.
Skeleton WithMarkerNames(const Skeleton& skeleton, MarkerNames names);

// The same joints and bones under our names (OurJointNames).
Skeleton WithOurNames(const Skeleton& skeleton);

// The skeleton specified by a file: its labels under our names, its bones, and
// its own name unless it is that of a built-in skeleton. A built-in set of
// joints in the same order is the built-in skeleton, with the file's bones if
// it has any. Without bones a human's are those of COCO-17 between the existing
// joints (IsHuman). Throws InputError "joints: ..." or "bones: ..." without a
// file name.
Skeleton SkeletonOfLabels(const std::vector<std::string>& labels,
                          const std::vector<Bone>& bones = {},
                          const std::string& name = "");

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TEXT_JOINT_NAMES_H_
