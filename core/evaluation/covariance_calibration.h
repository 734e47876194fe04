// Consistency of stated covariances with the errors that were made.
#ifndef KINEGRAPH_CORE_EVALUATION_COVARIANCE_CALIBRATION_H_
#define KINEGRAPH_CORE_EVALUATION_COVARIANCE_CALIBRATION_H_

#include <cstdint>
#include <vector>

#include "core/base/frame_range.h"
#include "core/data/pose.h"
#include "core/evaluation/correspondence.h"
#include "core/evaluation/held_out.h"
#include "core/evaluation/statistics.h"

namespace kinegraph {

// Squared Mahalanobis distances within which 95 % of normal errors lie: the
// quantiles of chi-square with 2 and 3 degrees of freedom.
inline constexpr double kChiSquare95Of2 = 5.991464547107979;
inline constexpr double kChiSquare95Of3 = 7.814727903251179;

struct Consistency {
  // Within the 95 % ellipse or ellipsoid. A covariance that is not positive
  // definite covers nothing.
  Share covered;
  // Normalised estimation error squared, mean per degree of freedom: 1 when the
  // covariances are right, larger when they are too sure (Bar-Shalom, Li,
  // Kirubarajan, Estimation with Applications to Tracking and Navigation,
  // section 5.4). NaN: no covariances.
  double nees_per_dof = 0.0;
};

// Of the joints with one status.
struct ConsistencyRow {
  JointStatus status = JointStatus::kObserved;
  // Errors of joints with a position, stated or not.
  int64_t count = 0;
  double rmse_m = 0.0;        // NaN: none
  Consistency stated;         // of those with a covariance
  double stated_rms_m = 0.0;  // square root of the covariances' mean trace
};

struct ConsistencyResult {
  ConsistencyRow observed;
  ConsistencyRow inferred;
  Consistency all;  // both together
};

// Joints are compared by name, people as EvaluateMpjpe pairs them. `frames` are
// those of the ground truth; none: all.
ConsistencyResult EvaluateConsistency(
    const TrackSequence& truth, const TrackSequence& tracks,
    const std::vector<FrameRange>& frames = {});

// The normalised residuals of held-out cameras.
Consistency HeldOutConsistency(const HeldOutScores& scores);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_COVARIANCE_CALIBRATION_H_
