// Short tracks of nobody: what false detections of several views make when they
// happen to meet.
#ifndef KINEGRAPH_CORE_IDENTITY_FALSE_POSITIVES_H_
#define KINEGRAPH_CORE_IDENTITY_FALSE_POSITIVES_H_

#include <vector>

#include "core/data/identity_edit.h"
#include "core/identity/tracklet.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph {

// Removals of tracks that by `min_margin` nats are rather nobody: their bones
// are not those of the recording's people, and they die as soon as they are
// born. Nobody who lives longer than 0.6 s is removed, and nobody of whom no
// bone was measured.
std::vector<IdentityEdit> FindFalsePositives(
    const Skeleton& skeleton, double min_margin,
    const std::vector<Tracklet>& tracks);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IDENTITY_FALSE_POSITIVES_H_
