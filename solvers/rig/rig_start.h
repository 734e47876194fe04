// Views put together: the tree of the pairs that say most, one scale, and
// whose tracklets are one person's.
#ifndef KINEGRAPH_SOLVERS_RIG_RIG_START_H_
#define KINEGRAPH_SOLVERS_RIG_RIG_START_H_

#include <vector>

#include "core/geometry/camera.h"
#include "core/skeleton/skeleton.h"
#include "core/tracking/replay.h"
#include "solvers/rig/tracklets.h"
#include "solvers/rig/view_pairs.h"

namespace kinegraph {

struct RigStart {
  // One a view, placed where `joined`; lengths are in baselines of the first
  // pair. Focal lengths as the pairs have them.
  CameraRig cameras;
  std::vector<char> joined;
  // Moment k of the recording is frame k + lag of a view.
  std::vector<int> lag_frames;
  int joined_count() const;
};

// `intrinsics`: of the guess that the tracklets were made with. Pairs of little
// evidence join nothing; the tree with the most is kept.
RigStart JoinPairs(const CameraRig& intrinsics,
                   const std::vector<ViewTracklet>& tracklets,
                   const std::vector<PairFit>& pairs,
                   const std::vector<Bone>& bones);

// The people of the joined views, from the matches of the pairs, the surest
// first. Frames are those of `detections` realigned by the lags.
FrozenMatches PeopleOf(const DetectionSequence& detections,
                       const std::vector<ViewTracklet>& tracklets,
                       const std::vector<PairFit>& pairs,
                       const RigStart& start);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_RIG_RIG_START_H_
