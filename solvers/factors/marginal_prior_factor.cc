#include "solvers/factors/marginal_prior_factor.h"

#include <glog/logging.h>

#include <utility>

#include "solvers/factors/state.h"

namespace kinegraph {

MarginalPriorFactor::MarginalPriorFactor(Eigen::MatrixXd A, Eigen::VectorXd x0,
                                         Eigen::VectorXd b)
    : A_(std::move(A)), x0_(std::move(x0)), b_(std::move(b)) {
  CHECK_EQ(A_.cols(), x0_.size());
  CHECK_EQ(A_.rows(), b_.size());
  CHECK_EQ(x0_.size() % kStateSize, 0);
  set_num_residuals(static_cast<int>(A_.rows()));
  mutable_parameter_block_sizes()->assign(x0_.size() / kStateSize, kStateSize);
}

bool MarginalPriorFactor::Evaluate(double const* const* parameters,
                                   double* residuals,
                                   double** jacobians) const {
  Eigen::Map<Eigen::VectorXd> residual(residuals, b_.size());
  residual = b_;
  const int block_count = static_cast<int>(x0_.size()) / kStateSize;
  for (int block = 0; block < block_count; ++block) {
    const auto columns = A_.middleCols<kStateSize>(block * kStateSize);
    const Eigen::Map<const State> state(parameters[block]);
    residual.noalias() +=
        columns * (state - x0_.segment<kStateSize>(block * kStateSize));
    if (jacobians == nullptr || jacobians[block] == nullptr) continue;
    Eigen::Map<
        Eigen::Matrix<double, Eigen::Dynamic, kStateSize, Eigen::RowMajor>>(
        jacobians[block], A_.rows(), kStateSize) = columns;
  }
  return true;
}

}  // namespace kinegraph
