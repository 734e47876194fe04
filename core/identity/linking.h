// Who is who over the whole recording: tracks joined, exchanged, cut and
// removed by all the evidence there is, not by what came first.
#ifndef KINEGRAPH_CORE_IDENTITY_LINKING_H_
#define KINEGRAPH_CORE_IDENTITY_LINKING_H_

#include <string>
#include <vector>

#include "core/data/identity_edit.h"
#include "core/data/pose.h"
#include "core/identity/options.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph {

// Decides and changes `frames` (ascending); returns what was done, in order.
// The same edits applied to the same frames give the same result (ApplyEdit).
// What was decided and does not fit is left out, with a line each in `left_out`
// (ApplyEdits).
//
// Tracks are cut where they may have gone on with the wrong person
// (tracklet.h). The pieces are then put together again as the assignment of
// each piece to the one before it, or to nobody, that has the greatest sum of
// log likelihood ratios: of bone lengths, of the motion across the gap, of
// going on as tracked (after Zhang, Li and Nevatia 2008, whose minimum-cost
// flow without reward for a piece is this assignment). Pieces that are seen at
// once are two people. A join counts when every assignment without it is worse
// by the margin; what was joined is one body from then on, and the rest is
// decided again.
std::vector<IdentityEdit> LinkIdentities(
    const Skeleton& skeleton, double frame_rate_hz, const LinkOptions& options,
    std::vector<TrackFrame>* frames,
    std::vector<std::string>* left_out = nullptr);

// Throws OptionError for a value out of range or entries that are no spheres.
void CheckLinkOptions(const LinkOptions& options);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IDENTITY_LINKING_H_
