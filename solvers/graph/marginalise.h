// Square-root marginalisation: what dropped variables say about kept ones.
#ifndef KINEGRAPH_SOLVERS_GRAPH_MARGINALISE_H_
#define KINEGRAPH_SOLVERS_GRAPH_MARGINALISE_H_

#include <Eigen/Core>

namespace kinegraph {

// residual(x) = A (x - x0) + b over the kept variables; A upper triangular.
struct SquareRootPrior {
  Eigen::MatrixXd A;
  Eigen::VectorXd b;
};

// `jacobian` (rows x columns) and `residual` (rows) are the whitened factors
// that touch the dropped variables, linearised at x0; the first `dropped`
// columns belong to those. A QR factorisation of [jacobian residual] leaves,
// below the rows of the dropped variables, the factor on the others. The
// minimum and the covariance of the kept variables are those of the whole
// (Kaess et al., iSAM2, IJRR 2012, sec. 2; Dellaert and Kaess, Factor Graphs
// for Robot Perception, 2017, sec. 5.3). Needs rows >= columns; directions
// about which nothing is known get a zero row.
SquareRootPrior Marginalise(const Eigen::MatrixXd& jacobian,
                            const Eigen::VectorXd& residual, int dropped);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_GRAPH_MARGINALISE_H_
