// The filters that offline_filter.h can apply to a joint, each with its
// options.
#ifndef KINEGRAPH_SOLVERS_FILTERS_SEGMENT_FILTERS_H_
#define KINEGRAPH_SOLVERS_FILTERS_SEGMENT_FILTERS_H_

#include "core/base/options.h"
#include "solvers/filters/butterworth.h"
#include "solvers/filters/centred_gaussian.h"
#include "solvers/filters/joint_points.h"
#include "solvers/filters/joint_segment.h"
#include "solvers/filters/kalman.h"
#include "solvers/filters/moving_median.h"
#include "solvers/filters/offline_filter.h"
#include "solvers/filters/one_euro.h"
#include "solvers/filters/robust_triangulation.h"
#include "solvers/filters/savitzky_golay.h"
#include "solvers/filters/smoothing_spline.h"

namespace kinegraph {

struct FilterOptions {
  // What filters smooth. The estimators raw_dlt and robust_triangulation are
  // these points themselves.
  PointKind points = PointKind::kDlt;
  OfflineFilterOptions segments;
  RobustTriangulationOptions robust_triangulation;
  CentredGaussianOptions centred_gaussian;
  HampelMedianOptions hampel_median;
  OneEuroOptions one_euro;
  ButterworthOptions butterworth;
  SavitzkyGolayOptions savitzky_golay;
  SmoothingSplineOptions smoothing_spline;
  KalmanOptions kalman;  // of the RTS smoother too

  // Table [filters], a table below it for each filter.
  void Describe(OptionVisitor& visitor);
};

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
