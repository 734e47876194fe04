// A skeleton as a tree of bones, and the motion of one person as rotations of
// these bones, for animation formats. For core/io only.
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
  // Index in the tree; parents precede children; the root is its own parent.
  size_t parent = 0;
  std::vector<int> sources;      // skeleton joints of which it is the mean
  std::vector<size_t> children;  // indices in the tree
  int mirror = -1;               // index of its counterpart on the other side
  // Unit vector from the parent in the rest pose (T-pose): upright, arms
  // extended sideways, palms down; x to the person's left, y up, z to the
  // front. Zero if the name does not determine it, and for a pivot.
  Eigen::Vector3d rest_direction = Eigen::Vector3d::Zero();
  // Length of the bone from the parent as a fraction of the stature (Drillis
  // and Contini, 1966, as in Winter, "Biomechanics and Motor Control of Human
  // Movement", 4th ed., fig. 4.1, and derived values, see joint_tree.cc); 0 if
  // unknown.
  double stature_share = 0.0;
  // Coincides with its parent and rotates one of several bones that begin
  // there.
  bool is_pivot = false;
  // Parent of both shoulders. The bone to its parent also contributes to its
  // rotation, but bones of the head do not.
  bool is_chest = false;
  bool is_head = false;
  // Connected to its parent by a bone or by anatomy. Other joints are
  // unconnected points, children of the root.
  bool is_held = true;
};
using JointTree = std::vector<TreeJoint>;

// Bones are used as they are, except those of a human skeleton if they form no
// tree or if there is no joint mid_hip; these are completed by anatomy:
// mid_hip is the centre of both hips if there is no such joint; likewise, neck
// is the centre of the shoulders; limbs are attached as in a body. Other joints
// are attached if a path of bones connects them to the root; otherwise points
// of a human's head become children of the nose, and all other points children
// of the root.
//
// The root of a human skeleton is mid_hip or, if it never occurs in the
// recording, neck; otherwise the root is the joint with the most bones among
// those that occur. `is_seen`: for each joint of the skeleton, whether it
// occurs in the recording.
//
// With `pivots`, each of several bones that begin at the same joint gets a
// joint of its own ("neck_to_l_shoulder"), so that rotations alone can give
// every bone its direction. The last bones of heads, hands and feet are rigid
// and get none.
JointTree MakeJointTree(const Skeleton& skeleton,
                        const std::vector<bool>& is_seen, bool pivots);

struct TreeMotion {
  // Position of each joint relative to its parent in the rest pose. Bones that
  // begin at the same joint have their mean shape in the recording, rotated to
  // fit the rest pose; a single bone has its rest direction. If names do not
  // determine a rest pose, a frame of the recording is used. Lengths are
  // medians. Bones that were never seen get the length of the other side, or
  // the length by the stature that the other bones imply, or a fifth of the
  // median bone, or 5 cm if no bone was seen.
  std::vector<Eigen::Vector3d> offsets_m;
  struct Row {
    std::vector<Eigen::Quaterniond> global;    // rotation from the rest pose
    std::vector<Eigen::Vector3d> positions_m;  // interpolated where missing
    std::vector<bool> is_seen;                 // not missing
  };
  std::vector<Row> rows;
  // Number of missing joints that were interpolated, over all rows in which the
  // person is present, without joints that are means of several.
  size_t filled = 0;
  std::vector<size_t> never_seen;  // indices in the tree

  // Rotation of a joint relative to its parent; for the root, its own.
  Eigen::Quaterniond Local(const JointTree& tree, size_t row,
                           size_t joint) const;
  // Positions that follow from the rotations and fixed bone lengths. The root
  // is at its observed position; if it was not seen, where the other joints fit
  // best.
  std::vector<Eigen::Vector3d> Rigid(const JointTree& tree, size_t row) const;
};

// Computes rotations from the directions of bones. A joint where several bones
// begin gets the rotation that fits their directions best, weighted by length
// (Wahba's problem, by SVD). A joint with a single bone gets the smallest
// rotation from its parent's orientation to the bone's direction, so that no
// bone twists relative to its parent. A joint without bones follows its parent.
// Where too few joints were seen, rotations (by slerp) and positions in the
// parent's frame are interpolated between known rows, and corrected by the
// smallest rotation that fits the joints that were seen. A joint that was never
// seen stays in its rest pose, or lies on the line to the next joint that was
// seen.
//
// `poses` has one entry per row, null where the person is absent; the first and
// the last are not null. The result is in the file's axes.
TreeMotion SolveTreeMotion(const JointTree& tree,
                           const std::vector<const PersonPose*>& poses,
                           const AxisMap& axes);

// Notes on what the trees of all people cannot represent.
class TreeLosses {
 public:
  // Adds the motion of a person; `person` is the name in notes.
  void See(const JointTree& tree, const TreeMotion& motion,
           const std::string& person);
  // Notes joints that were interpolated in time, joints that were never seen
  // and joints without a bone.
  void Note(const JointTree& tree, LostFields* lost_fields) const;

 private:
  size_t filled_ = 0;
  // People by the list of their joints that were never seen.
  std::map<std::string, std::vector<std::string>> people_;
  bool by_stature_ = false;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TRACKS_TREE_MOTION_H_
