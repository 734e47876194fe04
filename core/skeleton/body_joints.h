// What is known of human bodies, by the names of joints.
#ifndef KINEGRAPH_CORE_SKELETON_BODY_JOINTS_H_
#define KINEGRAPH_CORE_SKELETON_BODY_JOINTS_H_

#include <string>

#include "core/skeleton/skeleton.h"

namespace kinegraph {

// Shoulders to wrists and hips to ankles: the joints that every detector finds,
// and that move.
bool IsBodyJoint(JointClass joint_class);

// Whether only animals have what the label says: "Tail_base", "tailbase",
// "ForepawL", "wingR" and "root of tail", but not "ponytail".
bool IsAnimalPart(const std::string& label);

// Whether the joints are those of a human, so that what is known of human
// bones, heights and speeds applies: one whole arm or leg at least, and nothing
// that only animals have, such as a tail or a paw.
bool IsHuman(const Skeleton& skeleton);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_SKELETON_BODY_JOINTS_H_
