// One joint in one frame by its views alone, so that motion has no part in it:
// where it stands and how sure that is, and what the detector's confidence is
// worth in this recording, by which power of it errors shrink.
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

// How the modelled sigmas are to be changed.
struct ConfidenceWeighting {
  // Added to the power that the noise model believes in (GraphOptions::
  // confidence_power).
  double added_power = 0.0;
  // ln confidence at which nothing changes: the mean of what was seen, so that
  // the size of the errors is left to NoiseScales.
  double mean_log = 0.0;

  // On the modelled sigma of a measurement with that ln confidence.
  double SigmaFactor(double log_confidence) const {
    return added_power == 0.0
               ? 1.0
               : std::exp(-added_power * (log_confidence - mean_log));
  }
};

// Compares powers by how probable they make the residuals of least squares:
// the restricted likelihood of one triangulated joint (its position integrated
// out), with the tails of a t distribution for outliers, and each power with
// the size of errors that suits it best, by class of joint.
class ConfidenceLearner {
 public:
  // `believed_power` is where it starts; `frame_rate_hz` > 0.
  ConfidenceLearner(double believed_power, double frame_rate_hz);

  // The next frame: false when it follows the last one that was looked at too
  // soon to tell anything new (a detector's errors last), so that its joints
  // need not be added. `time` ascends.
  bool BeginFrame(TimeNs time);

  // A joint of one frame: what its views measured, with the sigmas of
  // `weighting` and the ln of their confidences, around the point where least
  // squares put it.
  void Add(JointClass joint_class, const std::vector<PixelPoint>& views,
           const std::vector<double>& log_confidences,
           const Eigen::Vector3d& point_m,
           const ConfidenceWeighting& weighting);

  // What was learnt so far; the believed power where it tells little.
  ConfidenceWeighting Fit() const;

 private:
  // ln of the factor on all sigmas: 1/16 to 16, as NoiseScales allows.
  static constexpr int kScaleCount = 15;
  using Scales = std::array<double, kScaleCount>;

  const double believed_power_;
  const double frame_s_;        // between frames that are looked at, at least
  const double weight_;         // of a frame
  std::optional<TimeNs> last_;  // that was looked at
  std::vector<double> powers_;  // that are compared, ascending
  // ln likelihood by power and class of joint.
  std::vector<std::array<Scales, kJointClassCount>> log_likelihood_;
  double mean_log_ = 0.0;
  int64_t count_ = 0;  // of views in the mean
};

// A robust point that may speak for the motion.
struct FramePoint {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Identity();
  std::vector<double> weights;  // of each of the triangulator's views
};

// Triangulates the measurements of single frames. Keeps work space.
class FrameTriangulator {
 public:
  // `cameras` must outlive the triangulator: the views are told by their
  // camera's place in it.
  explicit FrameTriangulator(const CameraRig& cameras);

  // From now on modelled sigmas are changed by it.
  void set_weighting(const ConfidenceWeighting& weighting) {
    weighting_ = weighting;
  }
  const ConfidenceWeighting& weighting() const { return weighting_; }

  // Takes the measurements of frame `k`, with the modelled sigmas and without
  // what is known of their bias. Least
  // squares over all views: false with fewer than two that see it, or where
  // they leave a direction open.
  bool Load(const JointChain& chain, size_t k);

  // Where least squares over all views put a joint.
  struct Start {
    Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
    bool found = false;
    bool by_all_views = false;  // none was left out
  };
  // Of the frame that was loaded last, and what Load said of it.
  const Start& start() const { return start_; }
  // Loads a frame again, without triangulating it.
  bool LoadAgain(const JointChain& chain, size_t k, const Start& start);

  const TriangulationResiduals& residuals() const { return residuals_; }
  const std::vector<PixelPoint>& views() const { return views_; }
  // ln, one a view.
  const std::vector<double>& log_confidences() const {
    return log_confidences_;
  }

  // The point that a redescending loss leaves, sigmas times `scale`. Narrowed
  // in stages from least squares (Huber, then Geman-McClure). nullopt unless
  // three or more views are inliers and more than half, or two of two.
  // Covariance: that of the loss, by InformationCorrection.
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
