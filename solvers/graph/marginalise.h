// Removes the first frame of a person's problem by marginalisation.
#ifndef KINEGRAPH_SOLVERS_GRAPH_MARGINALISE_H_
#define KINEGRAPH_SOLVERS_GRAPH_MARGINALISE_H_

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

#include "solvers/graph/problem.h"

namespace kinegraph {

// Replaces the first frame of every joint by the prior on its second state that
// follows from the first state's factors: prior, centre, measurements at their
// weights, motion. In a coupled problem (PersonProblem::coupled) adds one prior
// on the second states of all joints, which replaces the joints' own priors; if
// its information is not positive definite, it is left out with a warning, and
// the joints' own priors apply. `correction` is the InformationCorrection of
// the loss; it only affects the priors' information for covariances. Needs at
// least two frames.
void DropFirstFrame(double correction, PersonProblem* problem);

// Residual A (x - x0) + b over the kept variables; A upper triangular.
template <int kKept>
struct SquareRootPrior {
  Eigen::Matrix<double, kKept, kKept> A;
  Eigen::Matrix<double, kKept, 1> b;
};

// Takes the rows [J r] of whitened factors that touch the dropped variables,
// linearised at x0; the columns of the dropped variables come first. Rotating
// rows does not change their sum of squares, and Householder reflections bring
// them to an upper triangle,
//   |R11 d1 + R12 d2 + c1|^2 + |A d2 + b|^2 + a constant.
// For any d2, d1 = -R11^-1 (R12 d2 + c1) makes the first term zero: the second
// is the factor on the kept variables. A' A is the Schur complement of the
// information, without forming squares, which would cost half of the digits
// (Kaess et al., iSAM2, IJRR 2012, sec. 2; Dellaert and Kaess, Factor Graphs
// for Robot Perception, 2017, sec. 5.3). Directions without any information get
// a zero row.
template <int kColumns>
class RowTriangle {
 public:
  using Row = std::array<double, kColumns + 1>;  // residual last

  // In `row` and all earlier rows, columns `end` .. are zero. Adding rows with
  // fewer columns first is cheaper.
  void Add(const Row& row, int end = kColumns) {
    if (count_ == kMostRows || end != end_) Reduce();
    end_ = end;
    for (int column = 0; column <= kColumns; ++column) {
      columns_[column][count_] = row[column];
    }
    ++count_;
  }

  // The prior that remains when the first kDropped variables are eliminated. No
  // rows may be added afterwards.
  template <int kDropped>
  SquareRootPrior<kColumns - kDropped> Drop() {
    Reduce();
    SquareRootPrior<kColumns - kDropped> prior;
    prior.A.setZero();
    prior.b.setZero();
    for (int i = kDropped; i < std::min(count_, kColumns); ++i) {
      for (int column = i; column < kColumns; ++column) {
        prior.A(i - kDropped, column - kDropped) = columns_[column][i];
      }
      prior.b(i - kDropped) = columns_[kColumns][i];
    }
    return prior;
  }

 private:
  static constexpr int kMostRows = 48;
  using Part = Eigen::Map<Eigen::VectorXd>;

  // Householder reflections; leaves at most as many rows as columns.
  void Reduce() {
    for (int i = 0; i < end_ && i < count_; ++i) {
      Part pivot(&columns_[i][i], count_ - i);
      const double norm = pivot.norm();
      if (norm == 0.0) continue;
      const double left = pivot[0] > 0.0 ? -norm : norm;
      pivot[0] -= left;
      // Reflector I - v v' / (norm |v_0|).
      const double share = 1.0 / (norm * std::abs(pivot[0]));
      for (int column = i + 1; column <= kColumns; ++column) {
        if (column == end_) column = kColumns;
        Part other(&columns_[column][i], count_ - i);
        other -= share * pivot.dot(other) * pivot;
      }
      pivot.setZero();
      pivot[0] = left;
    }
    count_ = std::min(count_, end_);
  }

  double columns_[kColumns + 1][kMostRows];
  int count_ = 0;  // number of rows
  int end_ = 0;    // number of leading non-zero columns, without the residual
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_GRAPH_MARGINALISE_H_
