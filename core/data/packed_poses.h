// Poses in half of their memory: those of a whole recording that wait and may
// never be asked for.
#ifndef KINEGRAPH_CORE_DATA_PACKED_POSES_H_
#define KINEGRAPH_CORE_DATA_PACKED_POSES_H_

#include "core/base/byte_queue.h"
#include "core/data/pose.h"

namespace kinegraph {

// A queue of one person's poses. Every bit comes back.
class PackedPoses {
 public:
  // Takes everything out of `pose` but its identity.
  void Push(PersonPose* pose);
  bool empty() const { return poses_.empty(); }
  // Writes the oldest one, all but the identity.
  void RestoreFront(PersonPose* pose) const;
  void Pop() { poses_.Pop(); }

 private:
  ByteQueue poses_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_DATA_PACKED_POSES_H_
