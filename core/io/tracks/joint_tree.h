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
  int mirror = -1;            // in the tree: the same on the other side
  // Unit vector from the parent in the rest pose: a person who stands upright
  // with the arms stretched out sideways, palms down, x to the person's left, y
  // up, z to the front. Zero where the name tells none, and for a pivot.
  Eigen::Vector3d rest_direction = Eigen::Vector3d::Zero();
  // Length of the bone from the parent as a share of the stature (Drillis and
  // Contini, 1966, as in Winter, "Biomechanics and Motor Control of Human
  // Movement", 4th ed., fig. 4.1); 0 where they give none.
  double stature_share = 0.0;
  // Lies on its parent and turns one of several bones that begin there.
  bool is_pivot = false;
  // Both shoulders hang on it. It turns with the bone to its parent too, but
  // not with bones of the head.
  bool is_chest = false;
  bool is_head = false;
  // A bone or the body's anatomy joins it to its parent; the others hang on the
  // root as mere points.
  bool is_held = true;
};
using JointTree = std::vector<TreeJoint>;

// Bones that make a tree are taken as they are. Those of a human that do not,
// or that know no middle of the hips, are completed by anatomy: the root is
// mid_hip, the middle of both hips where there is no such joint, neck is the
// middle of the shoulders in the same way, and limbs hang as in a body. Of all
// others, whatever a path of bones leads to from the root, the joint with the
// most bones. `is_seen` says of each joint of the skeleton whether anybody has
// it: none that nobody has is the root, if it can be helped.
//
// With `pivots`, bones that begin where others do get a joint of their own each
// ("neck_to_l_shoulder"), so that rotations alone can give every bone its
// direction; but for the last bones of heads, hands and feet, which are rigid.
JointTree MakeJointTree(const Skeleton& skeleton,
                        const std::vector<bool>& is_seen, bool pivots);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TRACKS_JOINT_TREE_H_
