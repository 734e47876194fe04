// What a recording says of cameras and clocks together, at a bundle
// adjustment's solution: how sure each is, and which cannot be told apart.
#ifndef KINEGRAPH_SOLVERS_CAMERAS_REDUCED_SYSTEM_H_
#define KINEGRAPH_SOLVERS_CAMERAS_REDUCED_SYSTEM_H_

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include "core/geometry/camera.h"
#include "solvers/cameras/camera_change.h"
#include "solvers/cameras/segments.h"

namespace kinegraph {

// Pixels of a metre across the ray where a stretch begins. An offset has them
// fixed: were they to follow the estimate, the prior of the offsets would make
// people smaller, thus focal lengths longer.
inline double PxPerMetre(const Camera& camera, const MotionSegment& segment) {
  constexpr double kLeastDepthM = 0.1;
  return camera.focal_px() /
         std::max(kLeastDepthM, camera.Depth(PositionOf(segment)));
}

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
  // prior on a stretch's state. Cameras and segments must outlive the system.
  ReducedSystem(const CameraRig& cameras, const SceneSegments& segments,
                std::vector<std::vector<int>> places,
                const SegmentState& state_information);

  // What one stretch says.
  void Add(const MotionSegment& segment, const SegmentState& state,
           const std::vector<CameraChange>& changes);

  // Of the free parameters, view after view.
  const Eigen::MatrixXd& information() const { return information_; }
  Eigen::VectorXd Gradient() const;  // of the cost

  // After the last Add. What the calibration says, and what is held: `gauge`,
  // rows on all changes below each other, each zero but for `gauge_sigma`.
  void AddPrior(const CameraChange& inverse_sigma, const Eigen::MatrixXd& gauge,
                double gauge_sigma);

  // Errors of the detector that last for the whole recording: of each person's
  // joint in each view [m, each axis across the ray]. Called before Add.
  void SetLastingOffsets(double sigma_m) { offset_sigma_m_ = sigma_m; }

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
  void EliminateOffsets();

  const CameraRig& cameras_;
  const SceneSegments& segments_;
  const std::vector<std::vector<int>> places_;
  const SegmentState state_information_;
  std::vector<Eigen::Index> begin_;  // of each view's parameters
  Eigen::Index size_ = 0;
  Eigen::MatrixXd information_;
  // Gradients of the cost, by block of time.
  std::map<int64_t, Eigen::VectorXd> scores_;
  double offset_sigma_m_ = 0.0;
  std::map<std::array<int, 2>, Offsets> offsets_;  // person, joint
  Eigen::MatrixXd prior_scores_;  // of the offsets, for the sandwich
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_CAMERAS_REDUCED_SYSTEM_H_
