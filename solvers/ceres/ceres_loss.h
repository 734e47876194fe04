// The losses of loss.h as Ceres wants them.
#ifndef KINEGRAPH_SOLVERS_CERES_CERES_LOSS_H_
#define KINEGRAPH_SOLVERS_CERES_CERES_LOSS_H_

#include <ceres/loss_function.h>

#include "solvers/factors/loss.h"

namespace kinegraph {

// Geman and McClure (1985): rho(s) = c^2 s / (c^2 + s). Ceres 2.1 has none.
class GemanMcClureLoss final : public ceres::LossFunction {
 public:
  explicit GemanMcClureLoss(double scale) : scale_(scale) {}
  void Evaluate(double s, double rho[3]) const override;

 private:
  double scale_;
};

// The caller owns the result (a Ceres problem takes it). `information` >= 0
// scales the loss, not its threshold (ceres::ScaledLoss). Null when it would do
// nothing.
ceres::LossFunction* MakeCeresLoss(LossKind kind, double scale,
                                   double information);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_CERES_CERES_LOSS_H_
