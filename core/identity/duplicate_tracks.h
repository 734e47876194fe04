// Two tracks of one person at a time.
#ifndef KINEGRAPH_CORE_IDENTITY_DUPLICATE_TRACKS_H_
#define KINEGRAPH_CORE_IDENTITY_DUPLICATE_TRACKS_H_

#include <vector>

#include "core/data/identity_edit.h"
#include "core/identity/tracklet.h"

namespace kinegraph {

// Whether two tracks stand at the same place in nearly all frames that both
// have. False where they have none.
bool StandTogether(const Tracklet& a, const Tracklet& b);

// Removals of tracks that stand where a longer one stands nearly all their
// life.
std::vector<IdentityEdit> FindDuplicates(const std::vector<Tracklet>& tracks);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IDENTITY_DUPLICATE_TRACKS_H_
