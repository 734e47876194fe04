// The motion of one person as rotations of a tree of bones. For core/io alone.
#ifndef KINEGRAPH_CORE_IO_TRACKS_TREE_MOTION_H_
#define KINEGRAPH_CORE_IO_TRACKS_TREE_MOTION_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "core/data/pose.h"
#include "core/io/tracks/axis_map.h"
#include "core/io/tracks/joint_tree.h"

namespace kinegraph {

struct TreeMotion {
  // Of each joint from its parent at rest, where no rotation is left: for
  // joints with one child the direction of the rest pose, for others the mean
  // shape that they have in the take; as long as the bone's median.
  std::vector<Eigen::Vector3d> offsets_m;
  struct Row {
    std::vector<Eigen::Quaterniond>
        global;  // of each joint, from the rest pose
    std::vector<Eigen::Vector3d> positions_m;  // filled where they are missing
    std::vector<bool> is_seen;                 // not missing
  };
  std::vector<Row> rows;
  size_t filled = 0;  // joints that had no position in a row of the person

  Eigen::Quaterniond Local(const JointTree& tree, size_t row,
                           size_t joint) const;
  // Where the rotations alone put the joints, with bones of fixed lengths. The
  // root stands where it was seen, else where the others fit best.
  std::vector<Eigen::Vector3d> Rigid(const JointTree& tree, size_t row) const;
};

// Rotations from the directions of bones. A joint where several bones begin is
// turned to fit their directions best (Wahba's problem, by SVD); one with a
// single bone takes the smallest turn that leads from its parent's orientation
// to the bone's direction, so nothing turns a bone about itself that its
// parent does not; a joint without bones turns with its parent. Where joints
// are missing, rotations (by their arc) and places in the parent's frame go
// evenly from the last row known to the next; one that is never seen lies on
// its parent.
//
// `poses` has a row a frame, null where the person is not there; the first and
// the last are not null. Positions are those of the file's axes.
TreeMotion SolveTreeMotion(const JointTree& tree,
                           const std::vector<const PersonPose*>& poses,
                           const AxisMap& axes);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TRACKS_TREE_MOTION_H_
