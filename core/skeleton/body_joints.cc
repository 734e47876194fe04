#include "core/skeleton/body_joints.h"

namespace kinegraph {

bool IsBodyJoint(JointClass joint_class) {
  switch (joint_class) {
    case JointClass::kShoulder:
    case JointClass::kElbow:
    case JointClass::kWrist:
    case JointClass::kHip:
    case JointClass::kKnee:
    case JointClass::kAnkle:
      return true;
    default:
      return false;
  }
}

}  // namespace kinegraph
