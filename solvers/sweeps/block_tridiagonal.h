// Symmetric positive definite block-tridiagonal systems: the shape of every
// chain of states.
#ifndef KINEGRAPH_SOLVERS_SWEEPS_BLOCK_TRIDIAGONAL_H_
#define KINEGRAPH_SOLVERS_SWEEPS_BLOCK_TRIDIAGONAL_H_

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <vector>

namespace kinegraph {

// H = [D0 B0; B0' D1 B1; ...], blocks N x N (or Eigen::Dynamic). Block Cholesky
// from the first block to the last:
//   S_0 = D_0,  S_k = L_k L_k',  U_k = L_k^-1 B_k,  S_k+1 = D_k+1 - U_k' U_k.
template <int N>
class BlockTridiagonal {
 public:
  using Matrix = Eigen::Matrix<double, N, N>;
  using Vector = Eigen::Matrix<double, N, 1>;

  // Factorises; `upper` has one entry less than `diagonal`. False where H is
  // not positive definite (or not finite).
  bool Factorise(const std::vector<Matrix>& diagonal,
                 const std::vector<Matrix>& upper) {
    return Factorise(diagonal, upper, 0.0);
  }

  // The same for H + damping * diag(H).
  bool Factorise(const std::vector<Matrix>& diagonal,
                 const std::vector<Matrix>& upper, double damping) {
    const size_t count = diagonal.size();
    lower_.resize(count);
    upper_.resize(count > 0 ? count - 1 : 0);
    for (size_t k = 0; k < count; ++k) {
      Matrix& pivot = lower_[k];
      pivot = diagonal[k];
      if (damping > 0.0) pivot.diagonal() *= 1.0 + damping;
      if (k > 0) {
        pivot.template selfadjointView<Eigen::Lower>().rankUpdate(
            upper_[k - 1].transpose(), -1.0);
      }
      // In place: only the lower triangle is read and written.
      Eigen::LLT<Eigen::Ref<Matrix>> cholesky(pivot);
      if (cholesky.info() != Eigen::Success) return false;
      if (!pivot.diagonal().allFinite()) return false;
      if (k + 1 < count) {
        upper_[k] = upper[k];
        pivot.template triangularView<Eigen::Lower>().solveInPlace(upper_[k]);
      }
    }
    return true;
  }

  // Solves H x = rhs in place.
  void Solve(std::vector<Vector>* rhs) const {
    std::vector<Vector>& x = *rhs;
    const size_t count = lower_.size();
    for (size_t k = 0; k < count; ++k) {
      if (k > 0) x[k].noalias() -= upper_[k - 1].transpose() * x[k - 1];
      lower_[k].template triangularView<Eigen::Lower>().solveInPlace(x[k]);
    }
    for (size_t k = count; k-- > 0;) {
      if (k + 1 < count) x[k].noalias() -= upper_[k] * x[k + 1];
      lower_[k]
          .template triangularView<Eigen::Lower>()
          .transpose()
          .solveInPlace(x[k]);
    }
  }

  // The diagonal blocks of H^-1 (selected inversion), last to first:
  //   C_k = S_k^-1 + G_k C_k+1 G_k',  G_k = L_k^-T U_k.
  // `take(k, C_k)` is called for every k; nothing is stored.
  template <typename Take>
  void SelectedInverse(const Take& take) const {
    const size_t count = lower_.size();
    if (count == 0) return;
    const Eigen::Index size = lower_[0].rows();
    Matrix next;
    Matrix current;
    Matrix gain;
    Matrix product;
    for (size_t k = count; k-- > 0;) {
      const auto lower = lower_[k].template triangularView<Eigen::Lower>();
      current.setIdentity(size, size);
      lower.solveInPlace(current);  // L^-1
      if (k + 1 < count) {
        gain = upper_[k];
        lower.transpose().solveInPlace(gain);
        product.noalias() = gain * next;
        next.noalias() = current.transpose() * current;
        next.noalias() += product * gain.transpose();
      } else {
        next.noalias() = current.transpose() * current;
      }
      take(k, next);
    }
  }

 private:
  std::vector<Matrix> lower_;
  std::vector<Matrix> upper_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SWEEPS_BLOCK_TRIDIAGONAL_H_
