// Where one joint stands in one frame by its views alone, and how sure that is.
#ifndef KINEGRAPH_SOLVERS_NOISE_FRAME_POINTS_H_
#define KINEGRAPH_SOLVERS_NOISE_FRAME_POINTS_H_

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/geometry/triangulation.h"
#include "solvers/filters/robust_triangulation.h"
#include "solvers/graph/problem.h"
#include "solvers/noise/confidence_power.h"
#include "solvers/noise/pixel_noise.h"

namespace kinegraph {

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
  Start start() const;
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
  void RecordingViews(const JointChain& chain, size_t k);
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
