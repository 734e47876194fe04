// Are stated covariances right? Compares them with the errors that were made.
#ifndef KINEGRAPH_CORE_EVALUATION_CONSISTENCY_H_
#define KINEGRAPH_CORE_EVALUATION_CONSISTENCY_H_

#include <cstdint>
#include <vector>

#include "core/base/frame_range.h"
#include "core/data/pose.h"
#include "core/evaluation/correspondence.h"
#include "core/evaluation/statistics.h"

namespace kinegraph {

struct ConsistencyOptions {
  std::vector<FrameRange> frames;  // of the ground truth; none: all
  double gate_m = kPersonGateM;    // one-to-one, by mean distance
};

// Of the joints with one status.
struct ConsistencyRow {
  JointStatus status = JointStatus::kObserved;
  // Errors of joints with a position, stated or not.
  int64_t count = 0;
  double rmse_m = 0.0;  // NaN: none
  // Of those with a covariance C and an error e:
  // inside the ellipsoid e' C^-1 e <= 7.815, which holds 95 % of a normal
  // distribution in space (chi-square, three degrees of freedom);
  Share inside;
  // NEES, the mean of e' C^-1 e / 3: 1 when C is right (Bar-Shalom, Li,
  // Kirubarajan, Estimation with Applications to Tracking and Navigation,
  // section 5.4). NaN: none.
  double nees = 0.0;
  double stated_rms_m = 0.0;  // square root of the mean trace of C
};

// A covariance that is not positive definite covers nothing.
struct ConsistencyResult {
  ConsistencyRow observed;
  ConsistencyRow inferred;
};

// Joints are compared by name, people as EvaluateMpjpe pairs them.
ConsistencyResult EvaluateConsistency(const TrackSequence& truth,
                                      const TrackSequence& tracks,
                                      const ConsistencyOptions& options = {});

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_CONSISTENCY_H_
