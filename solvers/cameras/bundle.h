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
#include <array>
#include <cstdint>
#include <map>
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
  // Correlated samples per independent one, at least 1. The information of the
  // recording counts so many times, and the priors of rotations, centres,
  // shifts and focal lengths with it; their contribution to the covariance does
  // not.
  double samples_at_once = 1.0;
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

// ---- What a recording says of cameras and clocks together, at the solution:
// how sure each is, and which cannot be told apart ----

// The normal equations of the cameras' free parameters c, from which the states
// s_k of the people's motion segments are eliminated one by one: the reduced
// camera system of bundle adjustment (Triggs et al., Bundle Adjustment, 2000,
// sec. 6.1), with segments in place of points. Segments share cameras only, so
//   [U  W_1 W_2 ..] [dc ]     [g  ]
//   [W_1' V_1     ] [ds1] = - [h_1]
//   [W_2'     V_2 ] [ds2]     [h_2]
// and ds_k = -V_k^-1 (h_k + W_k' dc) leaves
//   (U - sum_k W_k V_k^-1 W_k') dc = -(g - sum_k W_k V_k^-1 h_k).
// With A = d residual / d state and B = d residual / d camera of a weighted
// observation, V_k sums A' A, W_k B' A, U B' B, h_k A' r and g B' r. The left
// bracket is the information of the cameras with the states unknown; the right
// one, segment by segment, is the score that the sandwich needs.
//
// A detector's offsets that last are eliminated likewise, person by person and
// joint by joint, in what the stretches leave.
class ReducedSystem {
 public:
  // `places`: the free parameters, one list a view. `state_information`: of the
  // prior on a stretch's state. `offset_sigma_m`: of the detector's errors that
  // last for the whole recording, of each person's joint in each view [m, each
  // axis across the ray]. Cameras and segments must outlive the system.
  ReducedSystem(const CameraRig& cameras, const SceneSegments& segments,
                std::vector<std::vector<int>> places,
                const SegmentState& state_information,
                double offset_sigma_m = 0.0);

  // What one stretch says.
  void Add(const MotionSegment& segment, const SegmentState& state,
           const std::vector<CameraChange>& changes);

  // Of the free parameters, view after view.
  const Eigen::MatrixXd& information() const { return information_; }
  Eigen::VectorXd Gradient() const;  // of the cost

  // After the last Add. The priors of the calibration, of which those that do
  // not concern clocks and lenses count `samples_at_once` times; and what is
  // held: `gauge`, rows on all changes below each other, each zero but for
  // `gauge_sigma`.
  void AddPrior(const CameraChange& inverse_sigma, double samples_at_once,
                const Eigen::MatrixXd& gauge, double gauge_sigma);

  // Covariance of the free parameters. Errors of a detector last, so it is the
  // sandwich over blocks of time (Huber and Ronchetti, Robust Statistics, ch.
  // 6), and never less than the inverse of the information. Empty where nothing
  // is free.
  Eigen::MatrixXd Covariance() const;

  // Largest correlation of a clock's parameter with a camera's, by the inverse
  // of the information; 0 without both.
  double LargestCorrelation() const;

 private:
  Eigen::MatrixXd Inverse() const;
  // What stretches of one person's joint say of its offsets in all views.
  struct Offsets {
    Eigen::MatrixXd cross;        // with the free parameters
    Eigen::MatrixXd information;  // two axes a view
    std::map<int64_t, Eigen::VectorXd> scores;
  };

  const CameraRig& cameras_;
  const SceneSegments& segments_;
  const std::vector<std::vector<int>> places_;
  const SegmentState state_information_;
  const double offset_sigma_m_;
  std::vector<Eigen::Index> begin_;  // of each view's parameters
  Eigen::Index size_ = 0;
  Eigen::MatrixXd information_;
  // Gradients of the cost, by block of time.
  std::map<int64_t, Eigen::VectorXd> scores_;
  std::map<std::array<int, 2>, Offsets> offsets_;  // person, joint
  Eigen::MatrixXd prior_scores_;  // of the offsets, for the sandwich
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_CAMERAS_BUNDLE_H_
