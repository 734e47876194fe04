// A joint's pixel in one view.
#ifndef KINEGRAPH_SOLVERS_FACTORS_REPROJECTION_FACTOR_H_
#define KINEGRAPH_SOLVERS_FACTORS_REPROJECTION_FACTOR_H_

#include <ceres/sized_cost_function.h>

#include "core/geometry/camera.h"
#include "solvers/factors/state.h"

namespace kinegraph {

// r = (project(camera, p + offset v) - u) / sigma_px                     [2]
//
// Block 0: state [p; v] [m, m/s]. `u` is a raw pixel, the lens is inside
// `project`. `offset_s` is the camera's own capture time less the frame's time.
// `sigma_px` is constant: one that depended on the state would reward drifting
// away. Evaluate fails (and Ceres rejects the step) where the point has no
// image: behind the camera or outside the lens' region; such a start is gated
// when a problem is assembled. One view leaves the depth free.
class ReprojectionFactor final
    : public ceres::SizedCostFunction<2, kStateSize> {
 public:
  // `camera` must outlive the factor; sigma_px > 0.
  ReprojectionFactor(const Camera* camera, const Eigen::Vector2d& px,
                     double sigma_px, double offset_s);
  static ceres::CostFunction* Create(const Camera* camera,
                                     const Eigen::Vector2d& px, double sigma_px,
                                     double offset_s) {
    return new ReprojectionFactor(camera, px, sigma_px, offset_s);
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const Camera* camera_;
  Eigen::Vector2d px_;
  double inverse_sigma_;
  double offset_s_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FACTORS_REPROJECTION_FACTOR_H_
