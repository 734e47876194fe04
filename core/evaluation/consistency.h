// Whether covariances tell the truth.
#ifndef KINEGRAPH_CORE_EVALUATION_CONSISTENCY_H_
#define KINEGRAPH_CORE_EVALUATION_CONSISTENCY_H_

#include <vector>

#include "core/base/frame_range.h"
#include "core/data/pose.h"
#include "core/evaluation/held_out.h"
#include "core/evaluation/statistics.h"

namespace kinegraph {

// Squared Mahalanobis distances within which 95 % of Gaussian errors lie: the
// quantiles of chi-square with 2 and 3 degrees of freedom.
inline constexpr double kChiSquare95Of2 = 5.991464547107979;
inline constexpr double kChiSquare95Of3 = 7.814727903251179;

struct Consistency {
  Share covered;  // within the 95 % ellipse or ellipsoid
  // Normalised estimation error squared, mean per degree of freedom: 1 when
  // right, larger when too sure (Bar-Shalom et al. 2001, section 5.4.2). NaN:
  // no covariances.
  double nees_per_dof = 0.0;
};

// Errors of joints of the same name against the truth, people paired within
// 0.5 m.
Consistency CovariancesAgainstTruth(const TrackSequence& truth,
                                    const TrackSequence& tracks,
                                    const std::vector<FrameRange>& frames = {});

// The normalised residuals of held-out cameras.
Consistency HeldOutConsistency(const HeldOutScores& scores);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_CONSISTENCY_H_
