// How a joint moves between two frames.
#ifndef KINEGRAPH_SOLVERS_FACTORS_CONSTANT_VELOCITY_FACTOR_H_
#define KINEGRAPH_SOLVERS_FACTORS_CONSTANT_VELOCITY_FACTOR_H_

#include <ceres/sized_cost_function.h>

#include "solvers/factors/state.h"

namespace kinegraph {

// The 2x2 lower-triangular factor L, Q = L L', of
//   Q(dt) = q [dt^3/3, dt^2/2; dt^2/2, dt]
// and the same for each axis. Whitening multiplies with its inverse.
struct ConstantVelocityNoise {
  // dt_s > 0 [s], q > 0 [m^2/s^3].
  ConstantVelocityNoise(double dt_s, double q);

  double dt_s;
  double position;  // L(0,0) [m]
  double cross;     // L(1,0) [m/s]
  double velocity;  // L(1,1) [m/s]
};

// r = L^-1 [p1 - p0 - dt v0; v1 - v0]                                    [6]
//
// Blocks 0, 1: states [p; v] [m, m/s] of two frames dt apart. White noise on
// acceleration with power q: Anderson and Barfoot, "Full STEAM ahead" (IROS
// 2015); Barfoot, State Estimation for Robotics, ch. 11. Holds for any dt, so
// gaps and dropped frames need no filling. Alone it leaves the common position
// and velocity of a chain free (birth_prior_factor.h).
class ConstantVelocityFactor final
    : public ceres::SizedCostFunction<kStateSize, kStateSize, kStateSize> {
 public:
  ConstantVelocityFactor(double dt_s, double q) : noise_(dt_s, q) {}
  static ceres::CostFunction* Create(double dt_s, double q) {
    return new ConstantVelocityFactor(dt_s, q);
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  ConstantVelocityNoise noise_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FACTORS_CONSTANT_VELOCITY_FACTOR_H_
