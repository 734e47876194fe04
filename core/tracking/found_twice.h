// People whom a detector found twice in one view, as it does where it looks at
// overlapping boxes.
#ifndef KINEGRAPH_CORE_TRACKING_FOUND_TWICE_H_
#define KINEGRAPH_CORE_TRACKING_FOUND_TWICE_H_

#include <cstddef>
#include <vector>

#include "core/data/observation.h"

namespace kinegraph {

// What becomes of them.
enum class FoundTwice { kKept, kDropped };

// Whether two observations of one view are one person: on average the joints
// that both found are apart by less than a twentieth of the larger one's box
// (some 9 cm on an adult), and they are at least half of those of the one that
// found fewer. Two people who overlap that well do so for a frame or two.
bool IsOnePerson(const Observation& a, const Observation& b);

// Of each person found twice keeps, at its place, what has more joints, then
// the more confident one, then the first. Returns how many are left, in front
// of the others; observations[count..] keep their memory.
size_t DropFoundTwice(size_t count, std::vector<Observation>* observations);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_TRACKING_FOUND_TWICE_H_
