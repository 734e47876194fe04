// All views of a joint in one frame as one Ceres cost function.
#ifndef KINEGRAPH_SOLVERS_CERES_VIEW_BUNDLE_H_
#define KINEGRAPH_SOLVERS_CERES_VIEW_BUNDLE_H_

#include <ceres/cost_function.h>

#include <vector>

#include "solvers/factors/camera_view.h"
#include "solvers/graph/state_key.h"

namespace kinegraph {

// Ceres spends more on a residual block than a projection costs, so views
// share one; each keeps its own loss, which is inside: of a view's whitened
// residual r with s = r'r it shows
//   r~ = sqrt(information rho(s) / s) r,
// so that 0.5 |r~|^2 is its cost, and as its Jacobian
//   sqrt(information) [sqrt(rho') (I - r r'/s) + rho' / sqrt(rho / s) r r'/s]
//   J,
// with which r~ has the true gradient information rho' J'r. Across r that is
// iteratively reweighted least squares; along r it counts an outlier for less,
// as its true curvature is less, and so converges in fewer steps.
class ViewBundle final : public ceres::CostFunction {
 public:
  // Not empty.
  struct View {
    CameraReprojection factor;
    Robustness robustness;
  };
  explicit ViewBundle(std::vector<View> views);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const std::vector<View> views_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_CERES_VIEW_BUNDLE_H_
