// The classical smoothers behind the Estimator interface.
#ifndef KINEGRAPH_SOLVERS_FILTERS_OFFLINE_FILTER_H_
#define KINEGRAPH_SOLVERS_FILTERS_OFFLINE_FILTER_H_

#include <memory>

#include "core/tracking/estimator.h"
#include "solvers/filters/joint_points.h"
#include "solvers/filters/joint_segment.h"
#include "solvers/filters/options.h"

namespace kinegraph {

// Collects all frames of a track and filters each joint separately in Finish(),
// which makes every pose final. The samples of a joint are the points found by
// JointPoints.
//
// Gaps are treated alike for every filter. Between two samples at most
// `max_gap_s` (or one frame, if that is longer) plus half a frame apart, the
// joint is bridged and inferred. A longer gap splits the signal into
// independent segments, and the joint is missing in it, as before its first and
// after its last sample. Bridged positions are interpolated linearly before
// filtering; the comment on the filters below states which of them use these
// positions. Where `cutoff_per` is the body, a filter whose cut-off is chosen
// by a rule runs twice: the second time all joints use the median of the chosen
// cut-offs, weighted by number of frames.
//
// Last() is the newest initial pose and Predict() returns the same positions as
// inferred joints, so the estimator should not be used for association. Throws
// OptionError for bad options; Finish() passes on exceptions of `filter`.
std::unique_ptr<Estimator> MakeOfflineFilter(
    const SceneModel& scene, const OfflineFilterOptions& options,
    JointPoints points, SegmentFilter filter);

// A fixed cut-off must be below half the nominal frame rate `rate_hz`
// (OptionError). Rules, cut-offs and windows use the segment's own rate where
// it differs by more than 0.5 %; a cut-off too high for that rate becomes 45 %
// (recursive filters) or half (Whittaker) of that rate. The recursive filters
// and Savitzky-Golay need uniform time: they throw InputError for a step more
// than half a frame off nominal.
//
// Bridged frames: the Gaussian, the centred median, the recursive filters and
// Savitzky-Golay treat the linear bridge as samples; PointsAsTheyAre returns
// it. One-Euro and the trailing median hold their last value. The other filters
// bridge the gap by their own model.
SegmentFilter PointsAsTheyAre(PointCovariances covariances);
SegmentFilter CentredGaussianFilter(const CentredGaussianOptions& options);
SegmentFilter HampelMedianFilter(const HampelMedianOptions& options);
SegmentFilter OneEuroFilter(const OneEuroOptions& options);
// Both use the table [filters.butterworth].
SegmentFilter ButterworthFilter(const ButterworthOptions& options,
                                double rate_hz,
                                CutoffPer per = CutoffPer::kJoint);
SegmentFilter CriticallyDampedFilter(const ButterworthOptions& options,
                                     double rate_hz,
                                     CutoffPer per = CutoffPer::kJoint);
SegmentFilter SavitzkyGolayFilter(const SavitzkyGolayOptions& options,
                                  double rate_hz);
// Segments of fewer than degree + 2 samples are returned unchanged.
SegmentFilter LoessFilter(const LoessOptions& options);
SegmentFilter TrendPointFilter(const TrendOptions& options);
// Segments of fewer than 2 m + 1 samples, m the derivative that measures
// roughness, are returned unchanged: too few to choose a smoothness.
SegmentFilter SmoothingSplineFilter(const SmoothingSplineOptions& options,
                                    double rate_hz,
                                    CutoffPer per = CutoffPer::kJoint);
SegmentFilter QuinticSplineFilter(const SmoothingSplineOptions& options,
                                  double rate_hz,
                                  CutoffPer per = CutoffPer::kJoint);
SegmentFilter WhittakerFilter(const WhittakerOptions& options, double rate_hz,
                              CutoffPer per = CutoffPer::kJoint);
SegmentFilter KalmanPointFilter(const KalmanOptions& options);
SegmentFilter RtsPointSmoother(const KalmanOptions& options);
SegmentFilter StudentTPointSmoother(const KalmanOptions& options);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FILTERS_OFFLINE_FILTER_H_
