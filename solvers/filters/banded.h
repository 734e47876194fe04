// Banded least squares and pentadiagonal linear systems.
#ifndef KINEGRAPH_SOLVERS_FILTERS_BANDED_H_
#define KINEGRAPH_SOLVERS_FILTERS_BANDED_H_

#include <Eigen/Core>

#include "solvers/filters/joint_segment.h"

namespace kinegraph {

// Minimises |A x - b|^2 by Givens rotations, row by row (Golub and Van Loan,
// Matrix Computations, section 5.2). The normal equations would square A's
// condition number, which is large for smooth curves, and lose twice as many
// digits. Rows in the order of their first unknown cost O(width^2) each.
class BandedLeastSquares {
 public:
  // Each row involves at most `width` neighbouring unknowns; b has `columns`
  // columns.
  BandedLeastSquares(Eigen::Index unknowns, int width, Eigen::Index columns);

  // Adds `factor` times a row with the entries `row` at the unknowns from
  // `first` on. An empty `b` stands for zeros.
  void AddRow(Eigen::Index first, double factor,
              const Eigen::Ref<const Eigen::VectorXd>& row,
              const Eigen::Ref<const Eigen::VectorXd>& b);

  // Row i of the resulting triangle, from unknown i on.
  Eigen::VectorXd TriangleRow(Eigen::Index i) const { return R_.col(i); }
  // The solution x: one row per unknown, one column per column of b.
  Samples Solve() const;
  // Row k: the k-th diagonal above the main one of (A'A)^-1, k < width; the
  // entry (i, i + k) is in column i (Hutchinson and de Hoog 1985).
  Eigen::MatrixXd InverseBands() const;

 private:
  Samples SolveTriangle(Samples right) const;

  int width_;
  Eigen::MatrixXd R_;        // entry (i, i + k) of the triangle at (k, i)
  Eigen::MatrixXd right_;    // a column per unknown
  Eigen::VectorXd row_, b_;  // scratch
};

// L D L' of a symmetric positive definite matrix with two diagonals on each
// side of the main one.
class PentadiagonalFactors {
 public:
  explicit PentadiagonalFactors(Eigen::Index size)
      : d_(size), l1_(size), l2_(size) {}

  // Sets row i; rows must be set in ascending order. The entries are those at
  // columns i, i + 1 and i + 2; zero beyond the last column.
  void SetRow(Eigen::Index i, double diagonal, double first, double second);
  // Replaces the right-hand sides, one per column, by the solutions.
  void Solve(Samples* x) const;

  Eigen::Index size() const { return d_.size(); }
  double d(Eigen::Index i) const { return d_(i); }
  double l1(Eigen::Index i) const { return l1_(i); }  // L at i + 1, i
  double l2(Eigen::Index i) const { return l2_(i); }  // L at i + 2, i

 private:
  Eigen::VectorXd d_, l1_, l2_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FILTERS_BANDED_H_
