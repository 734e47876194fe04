// Comparison with centroids: results whose skeleton is a single joint.
#ifndef KINEGRAPH_CORE_EVALUATION_CENTRES_H_
#define KINEGRAPH_CORE_EVALUATION_CENTRES_H_

#include <optional>
#include <string>

#include "core/data/pose.h"

namespace kinegraph {

// Two results with one joint per person, its centre.
struct Centres {
  TrackSequence a, b;
  std::string note;  // what is compared with what
};
// Where the two have no joint in common and one has a single joint, which is
// taken to be a centroid; nullopt otherwise. The centre of other skeletons is
// the middle of the hips; without hips, in the skeleton or in a pose, the mean
// of the joints, which for a box is that of its top and bottom.
std::optional<Centres> ReducedToCentres(const TrackSequence& a,
                                        const TrackSequence& b);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_CENTRES_H_
