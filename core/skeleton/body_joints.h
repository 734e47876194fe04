// Tests of joint names: body joints, animals, humans.
#ifndef KINEGRAPH_CORE_SKELETON_BODY_JOINTS_H_
#define KINEGRAPH_CORE_SKELETON_BODY_JOINTS_H_

#include <string>

#include "core/skeleton/skeleton.h"

namespace kinegraph {

// Shoulders to wrists and hips to ankles: the joints that every detector
// reports, and that move.
bool IsBodyJoint(JointClass joint_class);

// Whether the label is that of an animal's part: "Tail_base", "tailbase",
// "ForepawL", "wingR" and "root of tail", but not "ponytail".
bool IsAnimalPart(const std::string& label);

// Whether the joints are those of a human, so that assumptions about human
// bones, heights and speeds apply: at least one whole arm or leg, and no
// part that only animals have, such as a tail or a paw.
bool IsHuman(const Skeleton& skeleton);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_SKELETON_BODY_JOINTS_H_
