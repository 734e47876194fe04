// What a pose says besides its joints, in little memory: for poses of a whole
// take that wait and may never be asked for it.
#ifndef KINEGRAPH_CORE_DATA_PACKED_DETAILS_H_
#define KINEGRAPH_CORE_DATA_PACKED_DETAILS_H_

#include <string>

#include "core/data/pose.h"

namespace kinegraph {

// Inlier views, covariances, matches and score. Every bit comes back.
class PackedDetails {
 public:
  // Takes them out of `pose`; its identity and joints stay.
  explicit PackedDetails(PersonPose* pose);
  void Restore(PersonPose* pose) const;

 private:
  std::string bytes_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_DATA_PACKED_DETAILS_H_
