// A skeleton as a tree of bones, for formats of animation. For core/io alone.
#ifndef KINEGRAPH_CORE_IO_TRACKS_JOINT_TREE_H_
#define KINEGRAPH_CORE_IO_TRACKS_JOINT_TREE_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/skeleton/skeleton.h"

namespace kinegraph {

struct TreeJoint {
  std::string name;
  int parent = -1;            // in the tree; parents come before children
  std::vector<int> sources;   // joints of the skeleton, whose mean it is
  std::vector<int> children;  // in the tree
  // Unit vector from the parent in the rest pose: a person who stands upright
  // with the arms stretched out sideways, x to the person's left, y up, z to
  // the front. Zero for a pivot.
  Eigen::Vector3d rest_direction = Eigen::Vector3d::Zero();
  // Lies on its parent and turns one of several bones that begin there.
  bool is_pivot = false;
  // Turns with the bone to its parent too, but not with bones of the head.
  bool is_chest = false;
  bool is_head = false;
};
using JointTree = std::vector<TreeJoint>;

// The root is mid_hip, the middle of both hips where there is no such joint;
// neck is the middle of the shoulders in the same way. Limbs hang as in a body,
// everything else as the bones go; what nothing holds hangs on the nose, if it
// is of the head, or on the root. A skeleton without hips has the joint with
// the most bones as root.
//
// With `pivots`, each bone that goes on from a joint where several begin gets
// one of its own ("neck_to_l_shoulder"), so that rotations alone can give every
// bone its direction.
JointTree MakeJointTree(const Skeleton& skeleton, bool pivots);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TRACKS_JOINT_TREE_H_
