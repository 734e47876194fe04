// Identities over the whole recording: tracks are joined, exchanged, cut and
// removed by all the available evidence, regardless of order in time.
#ifndef KINEGRAPH_CORE_IDENTITY_LINKING_H_
#define KINEGRAPH_CORE_IDENTITY_LINKING_H_

#include <string>
#include <vector>

#include "core/data/identity_edit.h"
#include "core/data/pose.h"
#include "core/identity/options.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph {

// Changes `frames` (ascending) and returns the edits in order. The same edits
// applied to the same frames give the same result (ApplyEdit). Edits that prove
// invalid are omitted, with a line each in `left_out` (ApplyEdits). Throws as
// CheckLinkOptions does.
//
// Tracks that nearly always coincide with another one at least as long are
// removed first. The others are cut where they may have continued with the
// wrong person (tracklet.h). The pieces are then joined by the assignment of
// each piece to its predecessor, or to none, that has the greatest sum of log
// likelihood ratios: of bone lengths, of the motion across the gap, of
// continuing as tracked (after Zhang, Li and Nevatia 2008, whose minimum-cost
// flow without reward for a piece is this assignment). Pieces that overlap in
// time by half a second or more are different people, unless they nearly
// coincide there. A join is made when every assignment in which the two remain
// different people is worse by at least LinkOptions::min_margin; joined pieces
// are then treated as one, and the rest is decided again. Joins require no
// margin where the tracker continued a person, unless the pieces are clearly
// different people, or to reduce the people to LinkOptions::people. With the
// same margin, a piece present only while a known person is absent is inserted
// into that absence.
std::vector<IdentityEdit> LinkIdentities(
    const Skeleton& skeleton, double frame_rate_hz, const LinkOptions& options,
    std::vector<TrackFrame>* frames,
    std::vector<std::string>* left_out = nullptr);

// Throws OptionError for a value out of range or entries that are not spheres.
void CheckLinkOptions(const LinkOptions& options);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IDENTITY_LINKING_H_
