#include "solvers/filters/banded.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace kinegraph {

BandedLeastSquares::BandedLeastSquares(Eigen::Index unknowns, int width,
                                       Eigen::Index columns)
    : width_(width),
      R_(Eigen::MatrixXd::Zero(width, unknowns)),
      right_(Eigen::MatrixXd::Zero(columns, unknowns)),
      row_(width),
      b_(columns) {}

void BandedLeastSquares::AddRow(Eigen::Index first, double factor,
                                const Eigen::Ref<const Eigen::VectorXd>& row,
                                const Eigen::Ref<const Eigen::VectorXd>& b) {
  row_.setZero();
  row_.head(row.size()) = factor * row;
  b_.setZero();
  b_.head(b.size()) = factor * b;
  for (Eigen::Index i = first; i < R_.cols(); ++i) {
    if (row_(0) != 0.0) {
      const double radius = std::hypot(R_(0, i), row_(0));
      const double c = R_(0, i) / radius;
      const double s = row_(0) / radius;
      for (int k = 0; k < width_; ++k) {
        const double above = R_(k, i);
        R_(k, i) = c * above + s * row_(k);
        row_(k) = c * row_(k) - s * above;
      }
      for (Eigen::Index j = 0; j < b_.size(); ++j) {
        const double above = right_(j, i);
        right_(j, i) = c * above + s * b_(j);
        b_(j) = c * b_(j) - s * above;
      }
    }
    // The first entry is now zero: the row begins at the next unknown.
    std::copy(row_.data() + 1, row_.data() + width_, row_.data());
    row_(width_ - 1) = 0.0;
    if (row_.isZero(0.0)) return;
  }
}

Samples BandedLeastSquares::SolveTriangle(Samples right) const {
  for (Eigen::Index i = R_.cols() - 1; i >= 0; --i) {
    for (Eigen::Index k = 1; k < width_ && i + k < R_.cols(); ++k) {
      right.row(i) -= R_(k, i) * right.row(i + k);
    }
    right.row(i) /= R_(0, i);
  }
  return right;
}

Samples BandedLeastSquares::Solve() const {
  return SolveTriangle(right_.transpose());
}

Eigen::MatrixXd BandedLeastSquares::InverseBands() const {
  Eigen::MatrixXd P = Eigen::MatrixXd::Zero(width_, R_.cols());
  // With P = (A'A)^-1, R P is lower triangular with 1 / R(i, i) on its
  // diagonal: an entry of P follows from those to its right and below.
  for (Eigen::Index i = R_.cols() - 1; i >= 0; --i) {
    for (Eigen::Index j = width_ - 1; j >= 0; --j) {
      if (i + j >= R_.cols()) continue;
      double sum = j == 0 ? 1.0 / R_(0, i) : 0.0;
      for (Eigen::Index k = 1; k < width_ && i + k < R_.cols(); ++k) {
        sum -= R_(k, i) * P(std::abs(k - j), i + std::min(k, j));
      }
      P(j, i) = sum / R_(0, i);
    }
  }
  return P;
}

void PentadiagonalFactors::SetRow(Eigen::Index i, double diagonal, double first,
                                  double second) {
  if (i >= 1) {
    diagonal -= d_(i - 1) * l1_(i - 1) * l1_(i - 1);
    first -= d_(i - 1) * l1_(i - 1) * l2_(i - 1);
  }
  if (i >= 2) diagonal -= d_(i - 2) * l2_(i - 2) * l2_(i - 2);
  d_(i) = diagonal;
  l1_(i) = first / diagonal;
  l2_(i) = second / diagonal;
}

void PentadiagonalFactors::Solve(Samples* x) const {
  for (Eigen::Index i = 0; i < size(); ++i) {
    if (i >= 1) x->row(i) -= l1_(i - 1) * x->row(i - 1);
    if (i >= 2) x->row(i) -= l2_(i - 2) * x->row(i - 2);
  }
  for (Eigen::Index i = size() - 1; i >= 0; --i) {
    x->row(i) /= d_(i);
    if (i + 1 < size()) x->row(i) -= l1_(i) * x->row(i + 1);
    if (i + 2 < size()) x->row(i) -= l2_(i) * x->row(i + 2);
  }
}

}  // namespace kinegraph
