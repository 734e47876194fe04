// Triangulates a joint in one frame without a motion model, and learns how
// errors depend on the detector's confidence in a recording: sigma is
// proportional to confidence^-power.
#ifndef KINEGRAPH_SOLVERS_NOISE_FRAME_POINTS_H_
#define KINEGRAPH_SOLVERS_NOISE_FRAME_POINTS_H_

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/base/time.h"
#include "core/geometry/triangulation.h"
#include "core/skeleton/skeleton.h"
#include "solvers/filters/robust_triangulation.h"
#include "solvers/graph/problem.h"
#include "solvers/noise/pixel_noise.h"

namespace kinegraph {

// A correction of the modelled sigmas.
struct ConfidenceWeighting {
  // Added to the power assumed by the noise model (GraphOptions::
  // confidence_power).
  double added_power = 0.0;
  // ln confidence at which nothing changes: the mean over the recording, so
  // that the size of the errors is left to NoiseScales.
  double mean_log = 0.0;

  // Factor of the modelled sigma of a measurement with the given ln confidence.
  double SigmaFactor(double log_confidence) const {
    return added_power == 0.0
               ? 1.0
               : std::exp(-added_power * (log_confidence - mean_log));
  }
};

// Compares powers by the restricted likelihood of the least-squares residuals
// (the triangulated positions are integrated out), with the tails of a t
// distribution for outliers, and with the best size of errors for each power
// and class of joint.
class ConfidenceLearner {
 public:
  // `believed_power`: mean of the prior. `frame_rate_hz` > 0.
  ConfidenceLearner(double believed_power, double frame_rate_hz);

  // Begins the next frame; `time` must ascend. False if it follows the last
  // used frame too soon to add information (a detector's errors are
  // correlated); its joints need not be added then.
  bool BeginFrame(TimeNs time);

  // Adds a joint of one frame: the measurements of its views, with sigmas
  // according to `weighting`, the ln of their confidences, and the
  // least-squares point.
  void Add(JointClass joint_class, const std::vector<PixelPoint>& views,
           const std::vector<double>& log_confidences,
           const Eigen::Vector3d& point_m,
           const ConfidenceWeighting& weighting);

  // The current estimate; equal to the prior if there is little evidence.
  ConfidenceWeighting Fit() const;

 private:
  // Number of factors of all sigmas: 1/16 to 16, as in NoiseScales.
  static constexpr int kScaleCount = 15;
  using Scales = std::array<double, kScaleCount>;

  const double believed_power_;
  const double frame_s_;        // minimum interval between used frames
  const double weight_;         // of a frame
  std::optional<TimeNs> last_;  // of the last used frame
  std::vector<double> powers_;  // candidates, ascending
  // ln likelihood by power, class of joint and scale.
  std::vector<std::array<Scales, kJointClassCount>> log_likelihood_;
  double mean_log_ = 0.0;
  int64_t count_ = 0;  // number of views in the mean
};

// A robust point suitable for estimating motion.
struct FramePoint {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Identity();
};

// Triangulates the measurements of single frames. Ignores that views are
// captured at different times, because velocities are not yet known: at 1 m/s
// an offset of 10 ms appears as an error of 1 cm. Reuses its memory.
class FrameTriangulator {
 public:
  // `cameras` must outlive the triangulator; views are identified by the index
  // of their camera.
  explicit FrameTriangulator(const CameraRig& cameras);

  // The weighting is applied to modelled sigmas from the next loaded frame on.
  void set_weighting(const ConfidenceWeighting& weighting) {
    weighting_ = weighting;
  }
  const ConfidenceWeighting& weighting() const { return weighting_; }

  // Loads the measurements of frame `k`, with the modelled sigmas and without
  // the known bias, and triangulates by least squares. Leaves out views whose
  // pixel cannot be undistorted or into which the joint's DLT cannot be
  // projected. False if fewer than two views remain, or if they leave a
  // direction undetermined.
  bool Load(const JointChain& chain, size_t k);

  // The least-squares position of a joint over the views that were not left
  // out.
  struct Start {
    Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
    bool found = false;
    bool by_all_views = false;  // whether no view was left out
  };
  // The start in the frame loaded last; `found` is Load's result.
  const Start& start() const { return start_; }
  // Loads a frame again, without triangulating it unless a view was left out.
  // `start`: what start() returned after Load() of this joint and frame.
  bool LoadAgain(const JointChain& chain, size_t k, const Start& start);

  const TriangulationResiduals& residuals() const { return residuals_; }
  const std::vector<PixelPoint>& views() const { return views_; }
  // Natural logarithms of the confidences, one per view.
  const std::vector<double>& log_confidences() const {
    return log_confidences_;
  }

  // The point that minimises a redescending loss, with sigmas times `scale`.
  // The loss is narrowed in stages, from least squares over Huber to
  // Geman-McClure. nullopt unless at least three views, and more than half, are
  // inliers, or both of two views. The covariance accounts for the loss by
  // InformationCorrection.
  std::optional<FramePoint> Robust(double scale);

 private:
  void LoadViews(const JointChain& chain, size_t k);
  bool SetResiduals();

  const CameraRig& cameras_;
  RobustTriangulator least_squares_;
  std::vector<RobustTriangulator> stages_;
  double correction_;
  ConfidenceWeighting weighting_;
  std::vector<PixelPoint> views_;
  std::vector<double> log_confidences_;
  std::vector<PixelPoint> scaled_;
  std::vector<PointMeasurement> ideal_;
  Start start_;
  TriangulationResiduals residuals_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_NOISE_FRAME_POINTS_H_
