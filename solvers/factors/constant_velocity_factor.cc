#include "solvers/factors/constant_velocity_factor.h"

#include <cmath>

namespace kinegraph {

ConstantVelocityNoise::ConstantVelocityNoise(double dt, double q)
    : dt_s(dt),
      position(std::sqrt(q * dt * dt * dt / 3.0)),
      cross(0.5 * std::sqrt(3.0 * q * dt)),
      velocity(0.5 * std::sqrt(q * dt)) {}

bool ConstantVelocityFactor::Evaluate(double const* const* parameters,
                                      double* residuals,
                                      double** jacobians) const {
  const Eigen::Map<const State> from(parameters[0]);
  const Eigen::Map<const State> to(parameters[1]);
  Eigen::Map<State> residual(residuals);
  // Forward substitution with L, axis by axis.
  residual.head<3>() =
      (to.head<3>() - from.head<3>() - noise_.dt_s * from.tail<3>()) /
      noise_.position;
  residual.tail<3>() =
      (to.tail<3>() - from.tail<3>() - noise_.cross * residual.head<3>()) /
      noise_.velocity;
  if (jacobians == nullptr) return true;

  using RowMajor6 =
      Eigen::Matrix<double, kStateSize, kStateSize, Eigen::RowMajor>;
  const double pp = 1.0 / noise_.position;
  const double vp = -noise_.cross / (noise_.velocity * noise_.position);
  const double vv = 1.0 / noise_.velocity;
  if (jacobians[0] != nullptr) {
    Eigen::Map<RowMajor6> by_from(jacobians[0]);
    by_from.setZero();
    by_from.topLeftCorner<3, 3>().diagonal().setConstant(-pp);
    by_from.topRightCorner<3, 3>().diagonal().setConstant(-pp * noise_.dt_s);
    by_from.bottomLeftCorner<3, 3>().diagonal().setConstant(-vp);
    by_from.bottomRightCorner<3, 3>().diagonal().setConstant(-vp * noise_.dt_s -
                                                             vv);
  }
  if (jacobians[1] != nullptr) {
    Eigen::Map<RowMajor6> by_to(jacobians[1]);
    by_to.setZero();
    by_to.topLeftCorner<3, 3>().diagonal().setConstant(pp);
    by_to.bottomLeftCorner<3, 3>().diagonal().setConstant(vp);
    by_to.bottomRightCorner<3, 3>().diagonal().setConstant(vv);
  }
  return true;
}

}  // namespace kinegraph
