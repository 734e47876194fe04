#include "core/tracking/final_poses.h"

#include <algorithm>
#include <iterator>

namespace kinegraph {

void MoveFinals(std::vector<FinalPose>* from, std::vector<FinalPose>* to) {
  std::move(from->begin(), from->end(), std::back_inserter(*to));
  from->clear();
}

void ExpectUnmoved(const Pose3d& last, Pose3d* pose) {
  *pose = last;
  for (Joint3d& joint : *pose) {
    if (joint.present()) joint.status = JointStatus::kInferred;
  }
}

}  // namespace kinegraph
