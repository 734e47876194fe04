// What frames that left a window still say about the ones that stay.
#ifndef KINEGRAPH_SOLVERS_FACTORS_MARGINAL_PRIOR_FACTOR_H_
#define KINEGRAPH_SOLVERS_FACTORS_MARGINAL_PRIOR_FACTOR_H_

#include <ceres/cost_function.h>

#include <Eigen/Core>

namespace kinegraph {

// r = A (x - x0) + b                                                  [rows]
//
// x: the blocks below each other, every one a state [p; v] [m, m/s]; A is a
// square root of the information (A'A), b the residual at x0. Rank as A's.
class MarginalPriorFactor final : public ceres::CostFunction {
 public:
  // A.cols() == x0.size(), a multiple of kStateSize; A.rows() == b.size().
  MarginalPriorFactor(Eigen::MatrixXd A, Eigen::VectorXd x0, Eigen::VectorXd b);
  static ceres::CostFunction* Create(const Eigen::MatrixXd& A,
                                     const Eigen::VectorXd& x0,
                                     const Eigen::VectorXd& b) {
    return new MarginalPriorFactor(A, x0, b);
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  Eigen::MatrixXd A_;
  Eigen::VectorXd x0_;
  Eigen::VectorXd b_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FACTORS_MARGINAL_PRIOR_FACTOR_H_
