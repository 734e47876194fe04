// Triangulation of one joint in one frame without a motion model, and the
// dependence of errors on the detector's confidence in this recording: sigma is
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

  // Factor on the modelled sigma of a measurement with that ln confidence.
  double SigmaFactor(double log_confidence) const {
    return added_power == 0.0
               ? 1.0
               : std::exp(-added_power * (log_confidence - mean_log));
  }
};

// Compares powers by the likelihood of the least-squares residuals: the
// restricted likelihood of one triangulated joint (its position integrated
// out), with the tails of a t distribution for outliers, and for each power the
// best size of errors by class of joint.
class ConfidenceLearner {
 public:
  // `believed_power` is the prior; `frame_rate_hz` > 0.
  ConfidenceLearner(double believed_power, double frame_rate_hz);

  // The next frame: false if it follows the last used one too soon to add
  // information (a detector's errors are correlated), so that its joints need
  // not be added. `time` ascends.
  bool BeginFrame(TimeNs time);

  // A joint of one frame: the measurements of its views, with the sigmas of
  // `weighting` and the ln of their confidences, around the least-squares
  // point.
  void Add(JointClass joint_class, const std::vector<PixelPoint>& views,
           const std::vector<double>& log_confidences,
           const Eigen::Vector3d& point_m,
           const ConfidenceWeighting& weighting);

  // The current estimate; the prior power while there is little evidence.
  ConfidenceWeighting Fit() const;

 private:
  // ln of the factor on all sigmas: 1/16 to 16, as NoiseScales allows.
  static constexpr int kScaleCount = 15;
  using Scales = std::array<double, kScaleCount>;

  const double believed_power_;
  const double frame_s_;        // least interval between used frames
  const double weight_;         // of a frame
  std::optional<TimeNs> last_;  // of the last used frame
  std::vector<double> powers_;  // candidates, ascending
  // ln likelihood by power and class of joint.
  std::vector<std::array<Scales, kJointClassCount>> log_likelihood_;
  double mean_log_ = 0.0;
  int64_t count_ = 0;  // number of views in the mean
};

// A robust point suitable for estimating motion.
struct FramePoint {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Identity();
  std::vector<double> weights;  // of each of the triangulator's views
};

// Triangulates the measurements of single frames. Reuses its work space.
class FrameTriangulator {
 public:
  // `cameras` must outlive the triangulator: views are identified by their
  // camera's index.
  explicit FrameTriangulator(const CameraRig& cameras);

  // Applied to modelled sigmas from the next frame loaded.
  void set_weighting(const ConfidenceWeighting& weighting) {
    weighting_ = weighting;
  }
  const ConfidenceWeighting& weighting() const { return weighting_; }

  // Takes the measurements of frame `k`, with the modelled sigmas and without
  // the known bias. Least squares over all views: false if fewer than two see
  // the joint, or they leave a direction undetermined.
  bool Load(const JointChain& chain, size_t k);

  // The least-squares position of a joint over all views.
  struct Start {
    Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
    bool found = false;
    bool by_all_views = false;  // none was left out
  };
  // For the frame loaded last, including Load's result.
  const Start& start() const { return start_; }
  // Loads a frame again, without triangulating it.
  bool LoadAgain(const JointChain& chain, size_t k, const Start& start);

  const TriangulationResiduals& residuals() const { return residuals_; }
  const std::vector<PixelPoint>& views() const { return views_; }
  // Natural logarithms, one per view.
  const std::vector<double>& log_confidences() const {
    return log_confidences_;
  }

  // The point that minimises a redescending loss, with sigmas times `scale`.
  // Narrowed in stages from least squares (Huber, then Geman-McClure). nullopt
  // unless at least three views, and more than half, are inliers, or two of
  // two. Covariance: that of the loss, by InformationCorrection.
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
