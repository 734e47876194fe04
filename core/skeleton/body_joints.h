// The joints that every detector finds, and that move.
#ifndef KINEGRAPH_CORE_SKELETON_BODY_JOINTS_H_
#define KINEGRAPH_CORE_SKELETON_BODY_JOINTS_H_

#include "core/skeleton/skeleton.h"

namespace kinegraph {

// Shoulders to wrists and hips to ankles.
bool IsBodyJoint(JointClass joint_class);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_SKELETON_BODY_JOINTS_H_
