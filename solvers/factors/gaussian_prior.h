// What is known of one state before anything was measured, or from frames that
// left a window.
#ifndef KINEGRAPH_SOLVERS_FACTORS_GAUSSIAN_PRIOR_H_
#define KINEGRAPH_SOLVERS_FACTORS_GAUSSIAN_PRIOR_H_

#include "solvers/factors/jacobian.h"

namespace kinegraph {

// r = A (x - x0) + b                                                     [6]
//
// Key: state x = [p; v] [m, m/s]. A is a square root of the information (A'A),
// upper triangular, stored column by column; b is the residual at x0. All
// three are someone else's and outlive the factor.
template <typename T>
struct GaussianPrior {
  static constexpr int kResiduals = kStateSize;
  static constexpr int kKeys = 1;
  using Jacobian = DenseJacobian<kResiduals, T>;

  const T* A;
  const T* x0;
  const T* b;

  bool Evaluate(const T* const (&states)[kKeys], T* residual,
                Jacobian* by_states) const {
    for (int row = 0; row < kStateSize; ++row) {
      residual[row] = b[row];
      for (int i = row; i < kStateSize; ++i) {
        residual[row] =
            residual[row] + A[kStateSize * i + row] * (states[0][i] - x0[i]);
      }
    }
    if (by_states == nullptr) return true;
    for (int row = 0; row < kStateSize; ++row) {
      for (int i = 0; i < kStateSize; ++i) {
        by_states->by_state[row][i] = A[kStateSize * i + row];
      }
    }
    return true;
  }
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FACTORS_GAUSSIAN_PRIOR_H_
