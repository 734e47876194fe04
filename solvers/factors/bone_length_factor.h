// The distance of two joints of one bone.
#ifndef KINEGRAPH_SOLVERS_FACTORS_BONE_LENGTH_FACTOR_H_
#define KINEGRAPH_SOLVERS_FACTORS_BONE_LENGTH_FACTOR_H_

#include <ceres/sized_cost_function.h>

#include "solvers/factors/state.h"

namespace kinegraph {

// r = (|p_a - p_b| - length) / sigma                                     [1]
//
// Blocks 0, 1: states [p; v] [m, m/s] of the bone's ends at one frame; length
// and sigma > 0 [m]. Where the ends coincide the direction is undefined: the
// residual stands, the Jacobian is zero, and other factors must part them.
class BoneLengthFactor final
    : public ceres::SizedCostFunction<1, kStateSize, kStateSize> {
 public:
  BoneLengthFactor(double length_m, double sigma_m)
      : length_m_(length_m), per_m_(1.0 / sigma_m) {}
  static ceres::CostFunction* Create(double length_m, double sigma_m) {
    return new BoneLengthFactor(length_m, sigma_m);
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  double length_m_;
  double per_m_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FACTORS_BONE_LENGTH_FACTOR_H_
