// Kalman filter and Rauch-Tung-Striebel smoother of one joint's points.
#ifndef KINEGRAPH_SOLVERS_FILTERS_KALMAN_H_
#define KINEGRAPH_SOLVERS_FILTERS_KALMAN_H_

#include <array>

#include "solvers/filters/joint_segment.h"
#include "solvers/filters/options.h"

namespace kinegraph {

// Linear model of a point in space with `derivatives` 2 (position, velocity) or
// 3 (and acceleration). Between two times dt apart the state moves
// deterministically, plus Q(dt), white noise of `power` on the next derivative
// (Bar-Shalom, Li and Kirubarajan, Estimation with Applications to Tracking and
// Navigation, sections 6.2.2 and 6.2.3).
struct PointModel {
  int derivatives = 2;
  double power = 1.0;  // m^2/s^3, or m^2/s^5
  // Uncertainty of the derivatives at a segment's first sample: m/s, m/s^2.
  static constexpr std::array<double, 2> kStartSigmas = {3.0, 30.0};
};

// Estimates at every time of the segment. The first sample, which must exist,
// provides position and position covariance of the initial state (one-point
// initialisation; section 5.5.3 of the same book). The segment must have
// covariances. The filter (Kalman 1960, Joseph's form of the update) uses
// samples up to each time; at times without a sample it predicts, so its
// covariance grows in a gap. The smoother (Rauch, Tung and Striebel 1965) uses
// the whole segment. No value is rejected.
SegmentEstimate KalmanFilter(const PointModel& model,
                             const JointSegment& segment);
SegmentEstimate RtsSmoother(const PointModel& model,
                            const JointSegment& segment);

// The smoother with heavy-tailed measurements: Student's t of four degrees of
// freedom around the position, with the samples' covariances as scales. By
// variational Bayes (Agamennoni, Nieto and Nebot, Approximate Inference in
// State-Space Models With Heavy-Tailed Noise, 2012): each sample's covariance R
// is divided by its weight
//   w = (4 + 3) / (4 + e' R^-1 e + tr(R^-1 P))
// with e the sample minus the smoothed position and P the position's
// covariance. Repeated until no weight changes by 1e-6 or more, at most 50
// times. Wrong samples lose their weight; none is rejected.
SegmentEstimate StudentTSmoother(const PointModel& model,
                                 const JointSegment& segment);

// The model for a class of joints.
PointModel ModelOf(const KalmanOptions& options, JointClass joint_class);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FILTERS_KALMAN_H_
