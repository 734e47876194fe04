// The filters that offline_filter.h can apply to a joint, each with its
// options.
#ifndef KINEGRAPH_SOLVERS_FILTERS_SEGMENT_FILTERS_H_
#define KINEGRAPH_SOLVERS_FILTERS_SEGMENT_FILTERS_H_

#include "solvers/filters/joint_points.h"
#include "solvers/filters/joint_segment.h"
#include "solvers/filters/options.h"

namespace kinegraph {

// Each checks its options against the frame rate [Hz] (OptionError). Filters
// that need uniform time throw InputError for a segment without.
//
// What they make of bridged frames: the Gaussian, the centred median,
// Butterworth and Savitzky-Golay take the linear bridge for samples. The causal
// ones (One-Euro, the trailing median) hold their last value. The spline, the
// Kalman filter and the RTS smoother go over the gap by their own model.
SegmentFilter PointsAsTheyAre(PointCovariances covariances);
SegmentFilter CentredGaussianFilter(const CentredGaussianOptions& options);
SegmentFilter HampelMedianFilter(const HampelMedianOptions& options);
SegmentFilter OneEuroFilter(const OneEuroOptions& options);
SegmentFilter ButterworthFilter(const ButterworthOptions& options,
                                double rate_hz);
SegmentFilter SavitzkyGolayFilter(const SavitzkyGolayOptions& options,
                                  double rate_hz);
// Fewer than five samples stay as they are: too few to choose a smoothness by.
SegmentFilter SmoothingSplineFilter(const SmoothingSplineOptions& options,
                                    double rate_hz);
SegmentFilter KalmanPointFilter(const KalmanOptions& options);
SegmentFilter RtsPointSmoother(const KalmanOptions& options);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FILTERS_SEGMENT_FILTERS_H_
