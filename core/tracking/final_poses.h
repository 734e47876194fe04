// What most estimators do with poses that are made.
#ifndef KINEGRAPH_CORE_TRACKING_FINAL_POSES_H_
#define KINEGRAPH_CORE_TRACKING_FINAL_POSES_H_

#include <vector>

#include "core/tracking/estimator.h"

namespace kinegraph {

// Moves all of `from` to the end of `to`: Estimator::ExtractFinals.
void MoveFinals(std::vector<FinalPose>* from, std::vector<FinalPose>* to);

// The pose `last` as what is expected later of somebody who stays: its joints
// are inferred.
void ExpectUnmoved(const Pose3d& last, Pose3d* pose);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_TRACKING_FINAL_POSES_H_
