#include "solvers/ceres/ceres_factor.h"

namespace kinegraph {

CeresPersonPrior::CeresPersonPrior(const PersonPrior* prior) : prior_(prior) {
  set_num_residuals(static_cast<int>(prior->A.rows()));
  mutable_parameter_block_sizes()->assign(prior->x0.size() / kStateSize,
                                          kStateSize);
}

bool CeresPersonPrior::Evaluate(double const* const* parameters,
                                double* residuals, double** jacobians) const {
  const size_t joint_count = parameter_block_sizes().size();
  PersonStates states(joint_count);
  for (size_t j = 0; j < joint_count; ++j) {
    states[j].push_back(Eigen::Map<const State>(parameters[j]));
  }
  Eigen::Map<Eigen::VectorXd>(residuals, num_residuals()) =
      prior_->Residual(states);
  if (jacobians == nullptr) return true;
  for (size_t j = 0; j < joint_count; ++j) {
    if (jacobians[j] == nullptr) continue;
    Eigen::Map<
        Eigen::Matrix<double, Eigen::Dynamic, kStateSize, Eigen::RowMajor>>(
        jacobians[j], num_residuals(), kStateSize) =
        prior_->A.middleCols<kStateSize>(kStateSize *
                                         static_cast<Eigen::Index>(j));
  }
  return true;
}

}  // namespace kinegraph
