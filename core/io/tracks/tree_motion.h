// The motion of one person as rotations of a tree of bones. For core/io alone.
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
#include "core/io/tracks/joint_tree.h"

namespace kinegraph {

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
    std::vector<Eigen::Quaterniond>
        global;  // of each joint, from the rest pose
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

// Names the joints that no bone holds.
void NoteUnheld(const JointTree& tree, LostFields* lost_fields);

// Collects over all people the joints that nobody saw, for a note.
class NeverSeen {
 public:
  void See(const JointTree& tree, const TreeMotion& motion,
           const std::string& person);
  void Note(LostFields* lost_fields) const;

 private:
  std::map<std::string, std::vector<std::string>> people_;  // by the joints
  bool by_stature_ = false;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TRACKS_TREE_MOTION_H_
