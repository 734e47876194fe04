// Comparison with centroids: results whose skeleton is a single joint.
#ifndef KINEGRAPH_CORE_EVALUATION_CENTRES_H_
#define KINEGRAPH_CORE_EVALUATION_CENTRES_H_

#include <optional>
#include <string>

#include "core/data/pose.h"

namespace kinegraph {

// Two results with one joint per person: the person's centre.
struct Centres {
  TrackSequence a, b;
  std::string note;  // what is compared with what
};
// Reduces both results to centres if they have no joint in common and one has a
// single joint, which is taken to be a centroid; nullopt otherwise. The centre
// of the other skeleton is its joint mid_hip or, if it has none, the middle of
// l_hip and r_hip; where one of these is missing, it is the mean of the pose's
// joints.
std::optional<Centres> ReducedToCentres(const TrackSequence& a,
                                        const TrackSequence& b);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_CENTRES_H_
