// Drops the first frame of a person's problem.
#ifndef KINEGRAPH_SOLVERS_GRAPH_MARGINALISE_H_
#define KINEGRAPH_SOLVERS_GRAPH_MARGINALISE_H_

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "solvers/graph/problem.h"

namespace kinegraph {

// The prior on a chain's second state that its first state's factors leave:
// prior, measurements at their weights, motion. `correction` is that of the
// loss (InformationCorrection); it enters A_stated alone. The chain needs two
// states.
StatePrior MarginaliseFirstState(const std::vector<TimeNs>& times,
                                 const JointChain& chain, double correction);

// The same for all joints together, where bones couple them: a prior on their
// second states, by Schur complement. With x1 the states of the first frame, x2
// those of the second, and the factors that touch x1 linearised at the
// estimate, the cost is, but for a constant,
//   1/2 [d1 d2] [L11 L21'] [d1] + [g1' g2'] [d1]
//               [L21 L22 ] [d2]             [d2]
// in the steps d1, d2. Whatever d2 is, d1 = -L11^-1 (g1 + L21' d2) is best; put
// in, it leaves a prior on d2 alone,
//   information L22 - L21 L11^-1 L21',   gradient g2 - L21 L11^-1 g1,
// whose minimum and inverse are those of the whole problem's second frame: what
// later factors add concerns d2 only. L11 = C C' is factored once; the columns
// of C^-1 L21' are what the product subtracts. Without bones, L11 falls into a
// block a joint, which EliminateDense uses.
// nullopt where the information is not positive definite, which takes a factor
// of the user's own that says so.
std::optional<PersonPrior> MarginaliseFirstFrame(const PersonProblem& problem,
                                                 double correction);

// Replaces the first frame of every joint by such a prior; with bones, or a
// person's prior from earlier ones, also the person's.
void DropFirstFrame(double correction, PersonProblem* problem);

// residual(x) = A (x - x0) + b over the kept variables; A upper triangular.
template <int kKept>
struct SquareRootPrior {
  Eigen::Matrix<double, kKept, kKept> A;
  Eigen::Matrix<double, kKept, 1> b;
};

// Takes the rows [J r] of whitened factors that touch the dropped variables,
// linearised at x0; the first columns belong to those. Rotating rows does not
// change their sum of squares, and Householder reflections bring them to an
// upper triangle,
//   |R11 d1 + R12 d2 + c1|^2 + |A d2 + b|^2 + a constant.
// Whatever d2 is, d1 = -R11^-1 (R12 d2 + c1) brings the first term to zero: the
// second is the factor on the kept variables. A' A is the Schur complement of
// the information, without the squares that would cost half of the digits
// (Kaess et al., iSAM2, IJRR 2012, sec. 2; Dellaert and Kaess, Factor Graphs
// for Robot Perception, 2017, sec. 5.3). Directions about which nothing is
// known get a zero row.
template <int kColumns>
class RowTriangle {
 public:
  using Row = std::array<double, kColumns + 1>;  // the residual last

  // Of `row` and of all that came before, columns `end` .. are zero. Rows that
  // leave columns out go first: they cost less.
  void Add(const Row& row, int end = kColumns) {
    if (count_ == kMostRows || end != end_) Reduce();
    end_ = end;
    for (int column = 0; column <= kColumns; ++column) {
      columns_[column][count_] = row[column];
    }
    ++count_;
  }

  // Nothing is added afterwards.
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

  // To as many rows as there are columns.
  void Reduce() {
    for (int i = 0; i < end_ && i < count_; ++i) {
      Part pivot(&columns_[i][i], count_ - i);
      const double norm = pivot.norm();
      if (norm == 0.0) continue;
      const double left = pivot[0] > 0.0 ? -norm : norm;
      pivot[0] -= left;
      // Of I - v v' / (norm |v_0|).
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
  int count_ = 0;  // of rows
  int end_ = 0;    // of columns that are not zero but for the residual's
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_GRAPH_MARGINALISE_H_
