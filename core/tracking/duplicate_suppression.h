// Duplicate suppression: detections of one view that show one person, as of a
// detector whose boxes overlap.
#ifndef KINEGRAPH_CORE_TRACKING_DUPLICATE_SUPPRESSION_H_
#define KINEGRAPH_CORE_TRACKING_DUPLICATE_SUPPRESSION_H_

#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

#include "core/data/observation.h"

namespace kinegraph {

// Whether two observations of one view are one person: on average the joints
// that both found are apart by less than a twentieth of the larger one's box
// (some 9 cm on an adult), and they are at least half of those of the one that
// found fewer. Two people who overlap that well do so for a frame or two.
bool IsOnePerson(const Observation& a, const Observation& b);
// The same, with the boxes around their joints.
bool IsOnePerson(const Observation& a, const Eigen::AlignedBox2d& box_a,
                 const Observation& b, const Eigen::AlignedBox2d& box_b);

// Of duplicates keeps, at the place of the first, the one with more joints,
// then the more confident one, then the first. Returns how many are left, in
// front of the others; observations[count..] keep their memory.
size_t SuppressDuplicates(size_t count, std::vector<Observation>* observations);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_TRACKING_DUPLICATE_SUPPRESSION_H_
