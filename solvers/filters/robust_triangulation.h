// Triangulates a point from several views, some of which may be wrong.
#ifndef KINEGRAPH_SOLVERS_FILTERS_ROBUST_TRIANGULATION_H_
#define KINEGRAPH_SOLVERS_FILTERS_ROBUST_TRIANGULATION_H_

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/geometry/camera.h"
#include "solvers/filters/options.h"

namespace kinegraph {

// A joint in one view.
struct PixelPoint {
  const Camera* camera = nullptr;
  Eigen::Vector2d px = Eigen::Vector2d::Zero();  // raw
  double sigma_px = 1.0;
};

// Views with a lower weight do not support a point (the default of
// GraphOptions::inlier_weight).
inline constexpr double kInlierWeight = 0.25;

struct RobustPoint {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Identity();
  std::vector<double> weights;  // of each view, 0 .. 1
  int inlier_views = 0;
};

// The point that minimises the sum of 0.5 rho(|project(X) - u|^2 / sigma^2)
// over the views: an M-estimator on raw pixels (Hartley and Zisserman, Multiple
// View Geometry, appendix 6.8), by Gauss-Newton with the loss's curvature along
// each residual, kept positive, which needs fewer steps than reweighting alone
// (Holland and Welsch 1977). Starts from the DLT of all views or of a pair,
// whichever has the lowest cost (as Fischler and Bolles 1981, but with all
// pairs instead of random ones), so that one wrong view in three does not
// determine the result.
class RobustTriangulator {
 public:
  // Throws OptionError for bad options.
  explicit RobustTriangulator(const RobustTriangulationOptions& options);

  // nullopt when no start is in front of its cameras, fewer than two views
  // support the result or they leave a direction undetermined. Covariance: the
  // inverse of the weighted normal matrix. Reduced weights of good views make
  // it an eighth too large at five views; InformationCorrection of the loss,
  // which assumes many measurements of each unknown, would make it a seventh
  // too small at two.
  std::optional<RobustPoint> Triangulate(
      const std::vector<PixelPoint>& views) const;

  // The minimum reached from `start_m`; nullopt when it is not finite, fewer
  // than two views support it or they leave a direction undetermined.
  std::optional<RobustPoint> TriangulateFrom(
      const Eigen::Vector3d& start_m,
      const std::vector<PixelPoint>& views) const;

 private:
  RobustTriangulationOptions options_;
};

// (sum J'J / sigma^2)^-1 [m^2] of a point triangulated from these views by any
// method; nullopt when they leave a direction undetermined.
std::optional<Eigen::Matrix3d> TriangulationCovariance(
    const std::vector<PixelPoint>& views, const Eigen::Vector3d& point_m);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FILTERS_ROBUST_TRIANGULATION_H_
