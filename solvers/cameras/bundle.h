// Cameras and clocks of a recording by bundle adjustment: what the calibration
// states is the prior, the people's short stretches (segments.h) are the
// points. Triggs et al., "Bundle Adjustment: A Modern Synthesis", 2000.
//
// Cost: 0.5 sum rho(|reprojection|^2) over measurements
//   + 0.5 sum |state prior|^2 over stretches (speed, acceleration)
//   + 0.5 sum |change / prior sigma|^2 over cameras + the gauge.
#ifndef KINEGRAPH_SOLVERS_CAMERAS_BUNDLE_H_
#define KINEGRAPH_SOLVERS_CAMERAS_BUNDLE_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/geometry/camera.h"
#include "solvers/cameras/camera_change.h"
#include "solvers/cameras/segments.h"

namespace kinegraph {

struct BundleOptions {
  SegmentOptions segments;
  // How far a calibration may be off; weak, so that a few seconds of people
  // outweigh it.
  double rotation_sigma_rad = 0.035;  // 2 degrees
  double centre_sigma_m = 0.1;
  double shift_sigma_px = 30.0;
  double focal_sigma = 0.05;
  // Logarithm of the focal length that is told over the one that the camera
  // has, one a view; empty: they are the same.
  std::vector<double> focal_told;
  double lens_sigma = 0.3;
  double offset_sigma_s = 0.5;
  double drift_sigma = 1e-3;
  // Standard deviation of a detector's offsets that last for the recording
  // [m, each axis across the ray]: one of each person, joint and view is
  // estimated with the cameras. 0: none.
  double lasting_offset_m = 0.0;
  // Stretches keep the velocities that they start with, for fits of clocks
  // alone: estimated together with these they take up what a detector is off
  // for longer than a stretch, and clocks go too far. Cameras must not be
  // fitted so, which the velocities would hold where they are.
  bool hold_velocities = false;
  // Cameras stay where they start; the covariance is theirs all the same.
  bool hold_cameras = false;
  bool wants_covariance = true;  // and correlations
  int max_iterations = 30;
};

struct BundleResult {
  bool usable = false;
  std::vector<CameraChange> changes;  // one a view
  // Covariance of the free parameters: view after view, in the order of
  // FreeParameters::Places, with errors that last (ReducedSystem::Covariance).
  Eigen::MatrixXd covariance;
  std::vector<std::vector<int>> places;  // of the free parameters, one a view
  // Largest correlation of a clock's parameter with a camera's, by the inverse
  // of the information; 0 without both.
  double largest_correlation = 0.0;

  // Standard deviation of a view's parameter; 0 where it was not estimated.
  double Sigma(size_t view, int place) const;
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

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_CAMERAS_BUNDLE_H_
