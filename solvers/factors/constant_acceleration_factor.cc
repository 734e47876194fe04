#include "solvers/factors/constant_acceleration_factor.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace kinegraph {
namespace {

using RowMajor9 =
    Eigen::Matrix<double, kJerkStateSize, kJerkStateSize, Eigen::RowMajor>;

// `axis`, each entry times the identity.
RowMajor9 ForAllAxes(const Eigen::Matrix3d& axis) {
  RowMajor9 block = RowMajor9::Zero();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      block.block<3, 3>(3 * row, 3 * column)
          .diagonal()
          .setConstant(axis(row, column));
    }
  }
  return block;
}

}  // namespace

ConstantAccelerationFactor::ConstantAccelerationFactor(double dt_s, double q) {
  const double t = dt_s;
  // In units of dt the covariance is well conditioned whatever dt is:
  // Q = q S Q1 S with S = diag(t^2, t, 1) sqrt(t).
  Eigen::Matrix3d unit;
  unit << 1.0 / 20.0, 1.0 / 8.0, 1.0 / 6.0,  //
      1.0 / 8.0, 1.0 / 3.0, 0.5,             //
      1.0 / 6.0, 0.5, 1.0;
  const Eigen::Matrix3d lower = unit.llt().matrixL();
  const Eigen::Vector3d scale =
      Eigen::Vector3d(t * t, t, 1.0) * std::sqrt(q * t);
  by_to_ = lower.triangularView<Eigen::Lower>().solve(
      Eigen::Matrix3d(scale.cwiseInverse().asDiagonal()));
  Eigen::Matrix3d advance;
  advance << 1.0, t, 0.5 * t * t,  //
      0.0, 1.0, t,                 //
      0.0, 0.0, 1.0;
  by_from_ = -by_to_ * advance;
}

bool ConstantAccelerationFactor::Evaluate(double const* const* parameters,
                                          double* residuals,
                                          double** jacobians) const {
  // A state's columns, read as a matrix, are p, v and a.
  const Eigen::Map<const Eigen::Matrix3d> from(parameters[0]);
  const Eigen::Map<const Eigen::Matrix3d> to(parameters[1]);
  Eigen::Map<Eigen::Matrix3d> residual(residuals);
  residual = from * by_from_.transpose() + to * by_to_.transpose();
  if (jacobians == nullptr) return true;
  if (jacobians[0] != nullptr) {
    Eigen::Map<RowMajor9> by_from(jacobians[0]);
    by_from = ForAllAxes(by_from_);
  }
  if (jacobians[1] != nullptr) {
    Eigen::Map<RowMajor9> by_to(jacobians[1]);
    by_to = ForAllAxes(by_to_);
  }
  return true;
}

}  // namespace kinegraph
