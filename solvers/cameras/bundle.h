// Bundle adjustment of a recording's cameras and clocks: the stated calibration
// is the prior, short segments of people's motion (segments.h) take the place
// of points. Triggs et al., "Bundle Adjustment: A Modern Synthesis", 2000.
//
// Cost: 0.5 sum rho(|reprojection|^2) over measurements
//   + 0.5 sum |state prior|^2 over segments (speed, acceleration)
//   + 0.5 sum |offset / prior sigma|^2 over constant detector offsets, if any
//   + 0.5 sum n |(change - mean) / prior sigma|^2 over cameras + the gauge,
// with n BundleOptions::samples_at_once (1 for clocks) and a mean of zero
// except for BundleOptions::focal_prior.
#ifndef KINEGRAPH_SOLVERS_CAMERAS_BUNDLE_H_
#define KINEGRAPH_SOLVERS_CAMERAS_BUNDLE_H_

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include "core/geometry/camera.h"
#include "solvers/cameras/camera_change.h"
#include "solvers/cameras/segments.h"

namespace kinegraph {

struct BundleOptions {
  SegmentOptions segments;
  // Prior standard deviations of a calibration, so large that a few seconds of
  // people outweigh the prior.
  double rotation_sigma_rad = 0.035;  // 2 degrees
  double centre_sigma_m = 0.1;
  double shift_sigma_px = 30.0;
  double focal_sigma = 0.05;
  // Mean of the prior on the focal change (kFocalAt), one per view: not zero if
  // the prior is centred on a focal length other than that of the `cameras` of
  // AdjustBundle. Empty: all zero.
  std::vector<double> focal_prior;
  double lens_sigma = 0.3;  // k1, k2
  double offset_sigma_s = 0.5;
  double drift_sigma = 1e-3;
  // Number of correlated samples per independent sample, at least 1. A fit
  // overestimates the recording's information by this factor, so the prior
  // information of camera parameters, not of clocks, is multiplied by it.
  // Covariance() remains correct: in the sandwich the scores of the prior are
  // scaled accordingly (AddPrior).
  double samples_at_once = 1.0;
  // Standard deviation of a detector's constant offsets [m, per axis
  // perpendicular to the ray]: one offset per person, joint and view is
  // estimated with the cameras. 0: no offsets.
  double lasting_offset_m = 0.0;
  // Keeps the segments' initial velocities and accelerations, for fits of
  // clocks only: velocities estimated with the clocks absorb detector errors
  // that persist over a segment, and clocks change too much. Not for fits of
  // cameras, which fixed velocities would hold in place.
  bool hold_velocities = false;
  // Keeps the cameras at their start but computes their covariance.
  bool hold_cameras = false;
  bool wants_covariance = true;  // and the largest correlation
  int max_iterations = 30;
};

struct BundleResult {
  bool usable = false;  // false: no segments, or the solver failed
  std::vector<CameraChange> changes;  // one per view
  // Covariance of the free parameters, view by view in the order of
  // FreeParameters::Places, including the effect of persistent errors
  // (ReducedSystem::Covariance).
  Eigen::MatrixXd covariance;
  std::vector<std::vector<int>> places;  // free parameters of each view
  // Largest correlation of a clock parameter with a camera parameter, by the
  // inverse information; 0 unless both are free.
  double largest_correlation = 0.0;
  // ReducedSystem::SamplesAtOnce, at least 1; 1 without covariance.
  double samples_at_once = 1.0;

  // Standard deviation of a view's parameter; 0 if it was not estimated.
  double Sigma(size_t view, int place) const;
};

// Estimates the free parameters of every view with a true entry in `moves`
// (empty: all), starting from `start`. If all centres are free, the cameras'
// mean rotation, mean translation and root mean square distance from their
// centroid are kept; if clocks are free, the first view's clock is the
// reference.
BundleResult AdjustBundle(const CameraRig& cameras,
                          const SceneSegments& segments,
                          const FreeParameters& free,
                          const std::vector<CameraChange>& start,
                          const BundleOptions& options,
                          const std::vector<char>& moves = {});

// ---- Information of a recording on cameras and clocks at the solution: their
// covariance and correlations ----

// The normal equations of the cameras' free parameters c, from which the states
// s_k of the people's motion segments are eliminated one by one: the reduced
// camera system of bundle adjustment (Triggs et al., Bundle Adjustment, 2000,
// sec. 6.1), with segments in place of points. Segments are coupled only by the
// cameras, so
//   [U  W_1 W_2 ..] [dc ]     [g  ]
//   [W_1' V_1     ] [ds1] = - [h_1]
//   [W_2'     V_2 ] [ds2]     [h_2]
// and ds_k = -V_k^-1 (h_k + W_k' dc) leaves
//   (U - sum_k W_k V_k^-1 W_k') dc = -(g - sum_k W_k V_k^-1 h_k).
// With A = d residual / d state and B = d residual / d camera of a weighted
// observation, V_k sums A' A, W_k B' A, U B' B, h_k A' r and g B' r. The left
// bracket is the information about the cameras with the states unknown; the
// right bracket, segment by segment, is the score that the sandwich estimator
// needs.
//
// A detector's constant offsets are then eliminated in the same way, per person
// and joint, from the resulting system.
class ReducedSystem {
 public:
  // `places`: the free parameters, one list per view. `state_information`:
  // information of the prior about a segment's state. `offset_sigma_m`:
  // standard deviation of the detector's constant error of one joint of one
  // person in one view [m, per axis perpendicular to the ray]; 0: no offsets.
  // Cameras and segments must outlive the system.
  ReducedSystem(const CameraRig& cameras, const SceneSegments& segments,
                std::vector<std::vector<int>> places,
                const SegmentState& state_information,
                double offset_sigma_m = 0.0);

  // Adds the information of one segment.
  void Add(const MotionSegment& segment, const SegmentState& state,
           const std::vector<CameraChange>& changes);

  // Information about the free parameters, view by view.
  const Eigen::MatrixXd& information() const { return information_; }
  Eigen::VectorXd Gradient() const;  // of the cost

  // To be called after the last Add, at the minimum. Eliminates the detector's
  // offsets, whose actual variance it estimates for the scores' covariance, and
  // adds the calibration's priors, multiplied by `samples_at_once` except for
  // clocks, and the constraints of `gauge`: its rows times the stacked changes
  // are zero with standard deviation `gauge_sigma`.
  void AddPrior(const CameraChange& inverse_sigma, double samples_at_once,
                const Eigen::MatrixXd& gauge, double gauge_sigma);

  // Covariance of the free parameters: the sandwich estimator over blocks of
  // time, because detector errors are correlated in time (Huber and Ronchetti,
  // Robust Statistics, ch. 6), and at least the inverse information in every
  // direction. A recording has few blocks for its many parameters, so the
  // variance of single directions may be too small by chance; the covariance of
  // the scores is therefore shrunk towards a multiple of the information: the
  // mean under an inverse Wishart prior that counts as many blocks as there are
  // parameters. Empty if nothing is free.
  Eigen::MatrixXd Covariance() const;

  // Number of correlated samples per independent sample: the variance of the
  // blocks' scores in units of the information.
  double SamplesAtOnce() const;

  // Largest correlation of a clock parameter with a camera parameter, by the
  // inverse information; 0 unless both are free.
  double LargestCorrelation() const;

 private:
  Eigen::MatrixXd Inverse() const;
  // Covariance of the sum of the scores, from blocks of time.
  Eigen::MatrixXd BlockVariance() const;
  Eigen::MatrixXd ScoreVariance() const;  // the same, shrunk
  // Terms of one person's joint that involve its offsets in all views.
  struct Offsets {
    Eigen::MatrixXd cross;        // with the free parameters
    Eigen::MatrixXd information;  // two axes per view
    std::map<int64_t, Eigen::VectorXd> scores;
  };

  const CameraRig& cameras_;
  const SceneSegments& segments_;
  const std::vector<std::vector<int>> places_;
  const SegmentState state_information_;
  const double offset_sigma_m_;
  std::vector<Eigen::Index> begin_;  // of each view's first parameter
  Eigen::Index size_ = 0;
  Eigen::MatrixXd information_;
  Eigen::MatrixXd measured_;  // the part due to measurements
  // Gradients of the cost, by block of time.
  std::map<int64_t, Eigen::VectorXd> scores_;
  std::map<std::array<int, 2>, Offsets> offsets_;  // person, joint
  // Score covariance of the priors; for offsets with their actual variance.
  Eigen::MatrixXd prior_scores_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_CAMERAS_BUNDLE_H_
