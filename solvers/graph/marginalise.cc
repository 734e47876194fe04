#include "solvers/graph/marginalise.h"

#include <glog/logging.h>

#include <Eigen/QR>

namespace kinegraph {

SquareRootPrior Marginalise(const Eigen::MatrixXd& jacobian,
                            const Eigen::VectorXd& residual, int dropped) {
  const Eigen::Index columns = jacobian.cols();
  const Eigen::Index kept = columns - dropped;
  CHECK_GE(dropped, 0);
  CHECK_GE(kept, 0);
  CHECK_GE(jacobian.rows(), columns);
  CHECK_EQ(jacobian.rows(), residual.size());
  Eigen::MatrixXd augmented(jacobian.rows(), columns + 1);
  augmented << jacobian, residual;
  const Eigen::HouseholderQR<Eigen::Ref<Eigen::MatrixXd>> qr(augmented);
  SquareRootPrior prior;
  prior.A = augmented.block(dropped, dropped, kept, kept)
                .triangularView<Eigen::Upper>();
  prior.b = augmented.block(dropped, columns, kept, 1);
  return prior;
}

}  // namespace kinegraph
