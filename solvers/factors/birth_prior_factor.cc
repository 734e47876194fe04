#include "solvers/factors/birth_prior_factor.h"

namespace kinegraph {

BirthPriorFactor::BirthPriorFactor(const Eigen::Vector3d& centre,
                                   double sigma_m, double sigma_mps)
    : centre_(centre), per_m_(1.0 / sigma_m), per_mps_(1.0 / sigma_mps) {}

bool BirthPriorFactor::Evaluate(double const* const* parameters,
                                double* residuals, double** jacobians) const {
  const Eigen::Map<const State> state(parameters[0]);
  Eigen::Map<State> residual(residuals);
  residual.head<3>() = per_m_ * (state.head<3>() - centre_);
  residual.tail<3>() = per_mps_ * state.tail<3>();
  if (jacobians != nullptr && jacobians[0] != nullptr) {
    Eigen::Map<Eigen::Matrix<double, kStateSize, kStateSize, Eigen::RowMajor>>
        jacobian(jacobians[0]);
    jacobian.setZero();
    jacobian.diagonal().head<3>().setConstant(per_m_);
    jacobian.diagonal().tail<3>().setConstant(per_mps_);
  }
  return true;
}

}  // namespace kinegraph
