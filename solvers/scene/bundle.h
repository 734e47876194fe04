// Cameras and clocks of a take by bundle adjustment: what the calibration
// states is the prior, the people's short stretches (segments.h) are the
// points. Triggs et al., "Bundle Adjustment: A Modern Synthesis", 2000.
//
// Cost: 0.5 sum rho(|reprojection|^2) over measurements
//   + 0.5 sum |state prior|^2 over stretches (speed, acceleration)
//   + 0.5 sum |change / prior sigma|^2 over cameras + the gauge.
#ifndef KINEGRAPH_SOLVERS_SCENE_BUNDLE_H_
#define KINEGRAPH_SOLVERS_SCENE_BUNDLE_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/geometry/camera.h"
#include "solvers/scene/camera_change.h"
#include "solvers/scene/segments.h"

namespace kinegraph {

struct BundleOptions {
  SegmentOptions segments;
  // How far a calibration may be off; weak, so that a few seconds of people
  // outweigh it.
  double rotation_sigma_rad = 0.035;  // 2 degrees
  double centre_sigma_m = 0.1;
  double shift_sigma_px = 30.0;
  double focal_sigma = 0.05;
  double offset_sigma_s = 0.5;
  double drift_sigma = 1e-3;
  int max_iterations = 30;
};

struct BundleResult {
  bool usable = false;
  int iterations = 0;
  std::vector<CameraChange> changes;  // one a view
  // Covariance of the free parameters: view after view, in the order of
  // FreeParameters::Places. Errors of a detector last, so it is the sandwich
  // over blocks of time (Huber and Ronchetti, Robust Statistics, ch. 6), not
  // the inverse of the information.
  Eigen::MatrixXd covariance;
  std::vector<std::vector<int>> places;  // of the free parameters, one a view
  // Largest correlation of a clock's parameter with a camera's, by the inverse
  // of the information; 0 without both.
  double largest_correlation = 0.0;
};

// Estimates the free parameters of every view whose entry in `moves` is true
// (empty: all). With centres free the mean rotation and translation of the
// cameras stay, and so does the scale that their distances give; with clocks
// free that of the first view is the reference.
BundleResult AdjustBundle(const CameraRig& cameras,
                          const SceneSegments& segments,
                          const FreeParameters& free,
                          const std::vector<CameraChange>& start,
                          const BundleOptions& options,
                          const std::vector<char>& moves = {});

// How well given cameras explain the take: each stretch's state is estimated
// for them, and its residuals summed by short bins of time.
struct FitError {
  // Sums of min(|residual|, cap) [px] and counts.
  std::vector<std::vector<double>> sum_px;  // [view][bin]
  std::vector<std::vector<double>> count;   // [view][bin]
  double MeanPx() const;                    // over everything
  double MeanPx(int view) const;
  // Takes the bins of `other` behind its own.
  void Append(const FitError& other);
};

// Length of a bin of time [s]: a twentieth of the take, between 0.2 and 1 s.
// Errors of a detector last a tenth of a second or so.
double BinLength(const SceneSegments& segments);
FitError MeasureFit(const CameraRig& cameras, const SceneSegments& segments,
                    const std::vector<CameraChange>& changes,
                    const BundleOptions& options, double cap_px = 30.0);

// The paired 95 % interval of MeanPx of `before` less that of `after`
// (moving blocks of two bins), over one view or all (-1).
struct FitGain {
  double before_px = 0.0;
  double after_px = 0.0;
  double low_px = 0.0;  // of the gain
  double high_px = 0.0;
  // The interval excludes zero: the cameras after explain the take better.
  bool certain() const { return low_px > 0.0; }
};
FitGain CompareFits(const FitError& before, const FitError& after,
                    int view = -1);

// The stretches of one half of the take (0 or 1), in time.
SceneSegments HalfOf(const SceneSegments& segments, int half);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SCENE_BUNDLE_H_
