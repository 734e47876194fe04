#include "core/data/pose.h"

#include <algorithm>

namespace kinegraph {

const char* ToString(JointStatus status) {
  switch (status) {
    case JointStatus::kObserved:
      return "observed";
    case JointStatus::kInferred:
      return "inferred";
    case JointStatus::kMissing:
      break;
  }
  return "missing";
}

int CountPresent(const Pose3d& pose) {
  return static_cast<int>(
      std::count_if(pose.begin(), pose.end(),
                    [](const Joint3d& joint) { return joint.present(); }));
}

}  // namespace kinegraph
