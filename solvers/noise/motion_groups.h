// Joints that are driven alike, and so share a level of process noise.
#ifndef KINEGRAPH_SOLVERS_NOISE_MOTION_GROUPS_H_
#define KINEGRAPH_SOLVERS_NOISE_MOTION_GROUPS_H_

#include <vector>

#include "core/skeleton/skeleton.h"

namespace kinegraph {

// Head, trunk, shoulders and hips move with the body: the joints of such a
// class are one group. Limbs do not: who walks swings one leg while the other
// stands, and who throws moves one arm. There the joints of a class that are on
// one side of the body are a group.
class MotionGroups {
 public:
  explicit MotionGroups(const Skeleton& skeleton);

  int size() const { return static_cast<int>(classes_.size()); }
  int of_joint(int joint_idx) const { return of_joint_[joint_idx]; }
  JointClass joint_class(int group) const { return classes_[group]; }
  // 1 over the number of groups of its class.
  double share_of_class(int group) const;

 private:
  std::vector<int> of_joint_;
  std::vector<JointClass> classes_;  // by group
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_NOISE_MOTION_GROUPS_H_
