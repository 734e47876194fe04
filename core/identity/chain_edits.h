// The decisions of chains.h as edits of tracks.
#ifndef KINEGRAPH_CORE_IDENTITY_CHAIN_EDITS_H_
#define KINEGRAPH_CORE_IDENTITY_CHAIN_EDITS_H_

#include <cstdint>
#include <vector>

#include "core/data/identity_edit.h"
#include "core/identity/chains.h"

namespace kinegraph {

// The edits that give the tracks that were cut into `linked` one number a
// chain, and those that stay undecided. `last_frame` is that of the recording.
std::vector<IdentityEdit> EditsOf(const LinkedPieces& linked,
                                  int64_t last_frame);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IDENTITY_CHAIN_EDITS_H_
