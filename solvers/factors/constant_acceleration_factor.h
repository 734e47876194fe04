// How a joint moves between two frames when its jerk is noise.
#ifndef KINEGRAPH_SOLVERS_FACTORS_CONSTANT_ACCELERATION_FACTOR_H_
#define KINEGRAPH_SOLVERS_FACTORS_CONSTANT_ACCELERATION_FACTOR_H_

#include <ceres/sized_cost_function.h>

#include <Eigen/Core>

namespace kinegraph {

// Position [m], velocity [m/s] and acceleration [m/s^2] in the world.
inline constexpr int kJerkStateSize = 9;
using JerkState = Eigen::Matrix<double, kJerkStateSize, 1>;

// r = L^-1 [p1 - p0 - dt v0 - dt^2/2 a0; v1 - v0 - dt a0; a1 - a0]         [9]
// with L L' = Q for each axis,
//   Q(dt) = q [dt^5/20, dt^4/8, dt^3/6; dt^4/8, dt^3/3, dt^2/2;
//              dt^3/6, dt^2/2, dt]
//
// Blocks 0, 1: states [p; v; a] of two frames dt_s > 0 apart; q > 0
// [m^2/s^5]. White noise on jerk: Tang, Yoon and Barfoot, "A
// White-Noise-on-Jerk Motion Prior for Continuous-Time Trajectory Estimation on
// SE(3)" (RA-L 2019), here in a vector space. Alone it leaves the first state
// of a chain free.
class ConstantAccelerationFactor final
    : public ceres::SizedCostFunction<kJerkStateSize, kJerkStateSize,
                                      kJerkStateSize> {
 public:
  ConstantAccelerationFactor(double dt_s, double q);
  static ceres::CostFunction* Create(double dt_s, double q) {
    return new ConstantAccelerationFactor(dt_s, q);
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  Eigen::Matrix3d by_from_;  // of one axis: -L^-1 F(dt)
  Eigen::Matrix3d by_to_;    // L^-1
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FACTORS_CONSTANT_ACCELERATION_FACTOR_H_
