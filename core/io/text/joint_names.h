// Names that other programs give to joints.
#ifndef KINEGRAPH_CORE_IO_TEXT_JOINT_NAMES_H_
#define KINEGRAPH_CORE_IO_TEXT_JOINT_NAMES_H_

#include <optional>
#include <string>
#include <vector>

#include "core/skeleton/skeleton.h"

namespace kinegraph {

// Our name for what a detector calls a joint, whatever its spelling:
// "left_shoulder", "LShoulder", "shoulder_left" and "Shoulder L" are
// l_shoulder, "Hip" is mid_hip, "Neck" neck, "Anna:LAnkle (mm)" l_ankle. A
// label that names no joint we know is given back as it is.
std::string JointNameOf(const std::string& label);

// Our names of a set of labels, one each and all different: of several that
// may be one joint the exactest is, the others keep names of their own
// ("left_ankle" and "left_foot" are l_ankle and l_foot; "left_hip" and
// "left_foot" l_hip and l_ankle). Where no label is exact, as of markers
// ("HEAD", "C7", "LTOE"), and of animals (IsAnimalPart) no vaguer one is.
std::vector<std::string> OurJointNames(const std::vector<std::string>& labels);

// The other way: "left_shoulder" for l_shoulder, "mouth_left" for l_mouth, as
// MediaPipe writes them; other names as they are.
std::string LongJointName(const std::string& joint);

// Whose names markers have in TRC and other files.
enum class MarkerNames { kOurs, kPose2Sim, kOpenSim };
inline constexpr char kMarkerNamesList[] = "ours, pose2sim, opensim";
// nullopt for a text that is none of the list.
std::optional<MarkerNames> ParseMarkerNames(const std::string& text);

// The same joints and bones under other names: Pose2Sim's "RHip", "RBigToe",
// "Head", "Hip" or, in BODY_25, "CHip"; `kOpenSim` the same but "midHip", as
// OpenCap hands them to OpenSim. JointNameOf reads all of them back.
Skeleton WithMarkerNames(const Skeleton& skeleton, MarkerNames names);

// The same joints and bones under our names (OurJointNames).
Skeleton WithOurNames(const Skeleton& skeleton);

// The skeleton that a file states: its labels under our names, its bones, and
// its own name where it is no built-in one's. A built-in set of joints in this
// order is the built-in skeleton, with the file's bones where it states any.
// Without bones a human's are those of COCO-17 between the joints that there
// are (IsHuman). Throws InputError "joints: ..." or "bones: ..." without a
// file.
Skeleton SkeletonOfLabels(const std::vector<std::string>& labels,
                          const std::vector<Bone>& bones = {},
                          const std::string& name = "");

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TEXT_JOINT_NAMES_H_
