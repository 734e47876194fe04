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
// l_shoulder, "Hip" is mid_hip, "Neck" neck. A label that names no joint we
// know is given back as it is.
std::string JointNameOf(const std::string& label);

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

// The same joints and bones under our names; unchanged where two of them would
// have one name.
Skeleton WithOurNames(const Skeleton& skeleton);

// A skeleton of labels: the built-in one with these joints in this order, else
// one called "custom" with the bones of COCO-17 between those it has. Throws
// InputError without a file when two labels are the same joint.
Skeleton SkeletonOfLabels(const std::vector<std::string>& labels);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TEXT_JOINT_NAMES_H_
