// Where people may be who were not tracked there: in gaps of their tracks, and
// before and after them. The second pass looks whether any view agrees.
#ifndef KINEGRAPH_CORE_TRACKING_PROPOSALS_H_
#define KINEGRAPH_CORE_TRACKING_PROPOSALS_H_

#include <vector>

#include "core/data/pose.h"

namespace kinegraph {

struct ProposedPerson {
  TrackId id;
  Pose3d joints;            // inferred
  double age_frames = 0.0;  // to the nearest frame in which they were tracked
};

// For each of `frames` (ascending) who may be there besides its people, by
// ascending identity: up to `reach_s` after and before a frame in which they
// are. Between two such frames joints lie on the line between them; beyond the
// ends the person stays where they were. `frame_rate_hz` is nominal.
std::vector<std::vector<ProposedPerson>> ProposePeople(
    const std::vector<TrackFrame>& frames, double reach_s,
    double frame_rate_hz);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_TRACKING_PROPOSALS_H_
