// NAME.identity.jsonl: decisions on identities, and corrections.
#ifndef KINEGRAPH_CORE_IO_TRACKS_IDENTITY_EDITS_H_
#define KINEGRAPH_CORE_IO_TRACKS_IDENTITY_EDITS_H_

#include <string>
#include <vector>

#include "core/data/identity_edit.h"

namespace kinegraph {

// JSON Lines, one edit per line:
//   {"op": "join", "persons": [3, 7], "frames": [120, 131],
//    "evidence": {"bones": 6.1, "motion": 2.3, "other": 4.92, "gap_s": 0.44,
//                 "bone_difference_m": 0.004}, "margin": 8.4}
// `op` is join, cut, swap, delete, name (with "name": "Anna") or undecided.
// Evidence and margin are optional and only informative. The first line may
// identify the tracks (side_files.h); it is skipped. Throws InputError naming
// file and line for a line that is not JSON, a missing op or persons, an
// unknown key or op, a malformed value, or an empty range of frames (which join
// and undecided may have, if two people overlap in time).
std::vector<IdentityEdit> ReadIdentityEdits(const std::string& path);

// The file appears only when complete. `tracks`: the fingerprint of the tracks
// to which the edits belong, or empty.
void WriteIdentityEdits(const std::string& path,
                        const std::vector<IdentityEdit>& edits,
                        const std::string& tracks = "");

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TRACKS_IDENTITY_EDITS_H_
