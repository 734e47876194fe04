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
// columns belong to those. Rotating the rows does not change their sum of
// squares, and a QR factorisation of [jacobian residual] rotates them to
//   |R11 d1 + R12 d2 + c1|^2 + |A d2 + b|^2 + a constant.
// Whatever d2 is, d1 = -R11^-1 (R12 d2 + c1) brings the first term to zero: the
// second is the factor on the kept variables. A' A is the Schur complement of
// the information, without the squares that would cost half of the digits
// (Kaess et al., iSAM2, IJRR 2012, sec. 2; Dellaert and Kaess, Factor Graphs
// for Robot Perception, 2017, sec. 5.3). Needs rows >= columns; directions
// about which nothing is known get a zero row.
SquareRootPrior Marginalise(const Eigen::MatrixXd& jacobian,
                            const Eigen::VectorXd& residual, int dropped);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_GRAPH_MARGINALISE_H_
