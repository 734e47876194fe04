// A skeleton as a tree of bones, and the motion of one person as their
// rotations, for formats of animation. For core/io alone.
#ifndef KINEGRAPH_CORE_IO_TRACKS_TREE_MOTION_H_
#define KINEGRAPH_CORE_IO_TRACKS_TREE_MOTION_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <map>
#include <string>
#include <vector>

#include "core/data/pose.h"
#include "core/io/text/lost_fields.h"
#include "core/io/tracks/axis_map.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph {

struct TreeJoint {
  std::string name;
  // In the tree, in which parents come before children; the root's is itself.
  size_t parent = 0;
  std::vector<int> sources;      // joints of the skeleton, whose mean it is
  std::vector<size_t> children;  // in the tree
  int mirror = -1;               // in the tree: the same on the other side
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

struct TreeMotion {
  // Of each joint from its parent at rest, where no rotation is left. The bones
  // that begin at one joint have the mean shape that they have in the
  // recording, turned to the rest pose as well as it goes; a bone that begins
  // alone has its direction. Where names tell no rest pose, a frame of the
  // recording is it. Lengths are the medians; of bones never seen that of the
  // other side, else by the stature that the others tell, else a fifth of the
  // median bone.
  std::vector<Eigen::Vector3d> offsets_m;
  struct Row {
    std::vector<Eigen::Quaterniond> global;    // of each joint, from its rest
    std::vector<Eigen::Vector3d> positions_m;  // filled where they are missing
    std::vector<bool> is_seen;                 // not missing
  };
  std::vector<Row> rows;
  size_t filled = 0;  // joints missing in a row, of those that others have
  std::vector<size_t> never_seen;  // in the tree

  Eigen::Quaterniond Local(const JointTree& tree, size_t row,
                           size_t joint) const;
  // Where the rotations alone put the joints, with bones of fixed lengths. The
  // root stands where it was seen, else where the others fit best.
  std::vector<Eigen::Vector3d> Rigid(const JointTree& tree, size_t row) const;
};

// Rotations from the directions of bones. A joint where several bones begin is
// turned to fit their directions best, longer bones weighing more (Wahba's
// problem, by SVD); one with a single bone takes the smallest turn that leads
// from its parent's orientation to the bone's direction, so nothing turns a
// bone about itself that its parent does not; a joint without bones turns with
// its parent. Where too few joints are seen, rotations (by their arc) and
// places in the parent's frame go evenly from the last row known to the next,
// and what is seen turns them by the least. A joint that is never seen stands
// as at rest, or on the line to the next one that is seen.
//
// `poses` has a row a frame, null where the person is not there; the first and
// the last are not null. Positions are those of the file's axes.
TreeMotion SolveTreeMotion(const JointTree& tree,
                           const std::vector<const PersonPose*>& poses,
                           const AxisMap& axes);

// What the trees of all people cannot tell of them, for notes.
class TreeLosses {
 public:
  void See(const JointTree& tree, const TreeMotion& motion,
           const std::string& person);
  // Joints that got a place between others of their own in time, those that
  // nobody saw, and those that no bone holds.
  void Note(const JointTree& tree, LostFields* lost_fields) const;

 private:
  size_t filled_ = 0;
  // By the joints that were never seen.
  std::map<std::string, std::vector<std::string>> people_;
  bool by_stature_ = false;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TRACKS_TREE_MOTION_H_
