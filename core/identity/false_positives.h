// Short tracks that are no person: false detections of several views that
// happen to meet.
#ifndef KINEGRAPH_CORE_IDENTITY_FALSE_POSITIVES_H_
#define KINEGRAPH_CORE_IDENTITY_FALSE_POSITIVES_H_

#include <vector>

#include "core/data/identity_edit.h"
#include "core/identity/tracklet.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph {

// Removals of tracks that are no person by at least `min_margin` nats: their
// bones are not those of the recording's people, and they end soon after they
// begin. Tracks longer than 0.6 s, or without a measured bone, are kept.
std::vector<IdentityEdit> FindFalsePositives(
    const Skeleton& skeleton, double min_margin,
    const std::vector<Tracklet>& tracks);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IDENTITY_FALSE_POSITIVES_H_
