// A pose in half of its memory, for poses of a whole take that wait and may
// never be asked for.
#ifndef KINEGRAPH_CORE_DATA_PACKED_POSE_H_
#define KINEGRAPH_CORE_DATA_PACKED_POSE_H_

#include <string>

#include "core/data/pose.h"

namespace kinegraph {

// Every bit comes back.
class PackedPose {
 public:
  // Takes everything out of `pose` but its identity.
  explicit PackedPose(PersonPose* pose);
  void Restore(PersonPose* pose) const;

 private:
  std::string bytes_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_DATA_PACKED_POSE_H_
