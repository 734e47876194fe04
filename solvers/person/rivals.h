// Where a solve may have believed the wrong views, and other places to start
// from.
#ifndef KINEGRAPH_SOLVERS_PERSON_RIVALS_H_
#define KINEGRAPH_SOLVERS_PERSON_RIVALS_H_

#include <cstddef>
#include <vector>

#include "solvers/graph/problem.h"

namespace kinegraph {

// Frames `begin` .. `end` - 1.
struct LostStretch {
  size_t begin = 0;
  size_t end = 0;
};

// Stretches of two frames or more in which at most half of three or more views
// are inliers. Gaps of up to three frames are bridged.
std::vector<LostStretch> LostStretches(const JointChain& chain,
                                       double inlier_weight);

// The measurements that a rival leaves out when it looks for another start, in
// the stretches and one frame around them: those that were believed, or all.
enum class RivalMask { kBelieved, kAll };
std::vector<char> MaskFor(RivalMask mask,
                          const std::vector<LostStretch>& stretches,
                          double inlier_weight, const JointChain& chain);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_PERSON_RIVALS_H_
