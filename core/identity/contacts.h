// Contacts: where tracks come so near to one another, or are lost or found so
// near to another, that the tracker may have continued with the wrong person.
#ifndef KINEGRAPH_CORE_IDENTITY_CONTACTS_H_
#define KINEGRAPH_CORE_IDENTITY_CONTACTS_H_

#include <utility>
#include <vector>

#include "core/identity/motion.h"
#include "core/identity/tracklet.h"

namespace kinegraph {

struct Pieces {
  std::vector<Tracklet> tracklets;  // by ascending identity, then time
  // The piece with which the tracker went on, or -1.
  std::vector<int> next;
  // Whether it did so blindly: cut because no view saw the person for a while.
  std::vector<char> blind;
  // Within a longer contact at whose cut the tracker continued: the states
  // before and after the frames that no view saw.
  using Hop = std::pair<MotionState, MotionState>;
  std::vector<std::vector<Hop>> hops;
};

// Cuts tracks at their contacts. A contact's frames are dirty on both sides of
// the cut.
Pieces CutAtContacts(const std::vector<Tracklet>& tracks);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IDENTITY_CONTACTS_H_
