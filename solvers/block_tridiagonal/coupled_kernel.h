// The arithmetic of LaneKernels::solve_coupled (chain_lanes.h), templated on
// the SIMD type (core/base/pack.h). Included by files that are compiled for one
// instruction set each, so it must not use Eigen.
//
// H = M + C, with M the damped chains and C the couplings. The next direction
// of conjugate gradients is z + turn * d, with M z = r, d the previous
// direction and turn the ratio of r'z to its previous value. M times the next
// direction is therefore r + turn * (M d): no product with M is needed.
#ifndef KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_COUPLED_KERNEL_H_
#define KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_COUPLED_KERNEL_H_

#include "core/base/pack.h"
#include "solvers/block_tridiagonal/chain_kernel.h"
#include "solvers/block_tridiagonal/chain_lanes.h"
#include "solvers/block_tridiagonal/lane_blocks.h"

namespace kinegraph {

// All arrays are rows of lanes. Frames are the outer loop and groups of lanes
// the inner one, so that the sweeps of the groups overlap in the processor.
template <typename T>
class CoupledSolve {
 public:
  // Rows of a frame: inverse, motion, five vectors, and a vector of positions.
  static constexpr long kRowsPerFrame = kLaneBlockSize + 4 + 5 * 6 + 3;

  CoupledSolve(const ChainLanes& chains, const LaneCouplings& couplings,
               double* workspace)
      : chains_(chains), couplings_(couplings), frames_(chains.frames) {
    const auto allot = [&](long rows) {
      double* const at = workspace;
      workspace += rows * chains.lanes;
      return at;
    };
    inverse_ = allot(static_cast<long>(kLaneBlockSize) * frames_);
    motion_ = allot(4L * frames_);
    residual_ = allot(6L * frames_);
    conditioned_ = allot(6L * frames_);
    direction_ = allot(6L * frames_);
    by_chains_ = allot(6L * frames_);
    solution_ = allot(6L * frames_);
    by_couplings_ = allot(3L * frames_);
    by_first_ = allot(6);
    sums_ = allot(1);
  }

  bool Factorise(const double* diagonal, double damping) {
    const T grown = 1.0 + damping;
    for (int lane = 0; lane < chains_.lanes; lane += T::kLanes) {
      StoreRow(T(1.0), sums_, 0, lane);  // 1: positive definite so far
    }
    for (int k = frames_; k-- > 0;) {
      for (int lane = 0; lane < chains_.lanes; lane += T::kLanes) {
        LaneBlock<T> pivot = LoadBlock(diagonal, k, lane);
        ScaleDiagonal(grown, &pivot);
        if (k + 1 < frames_) {
          const LaneAxis<T> m =
              MotionBetween<T>(chains_.dt_s[k],
                               Row(chains_.process_noise, k, lane))
                  .m;
          for (int i = 0; i < 4; ++i) {
            StoreRow(m.a[i / 2][i % 2], motion_, 4L * k + i, lane);
          }
          SubtractCongruence(m, LoadBlock(inverse_, k + 1, lane), &pivot);
        }
        LaneBlock<T> inverse;
        const Mask<T> definite = Invert(pivot, &inverse);
        StoreBlock(inverse, inverse_, k, lane);
        StoreRow(Select(definite, Row(sums_, 0, lane), T(0.0)), sums_, 0, lane);
      }
    }
    for (int lane = 0; lane < chains_.joints; ++lane) {
      if (sums_[lane] == 0.0) return false;
    }
    return true;
  }

  // After a successful factorisation. False where the gradient is not finite or
  // the first direction has no positive curvature.
  bool Solve(const double* gradient, double accuracy, double* step) {
    constexpr int kMaxIterations = 100;
    const long size = 6L * frames_ * chains_.lanes;
    for (long i = 0; i < size; ++i) {
      solution_[i] = 0.0;
      residual_[i] = -gradient[i];
    }
    double before = 0.0;
    double first = 0.0;
    for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
      const double now = Condition();
      if (iteration == 0) {
        if (!(0.0 * now == 0.0)) return false;  // NaN, infinite
        first = now;
      }
      if (!(now > accuracy * accuracy * first)) break;
      const double chains = Turn(iteration == 0 ? 0.0 : now / before);
      before = now;
      const double curvature = chains + Couple();
      if (!(curvature > 0.0)) {
        if (iteration == 0) return false;
        break;
      }
      Advance(now / curvature);
    }
    for (long i = 0; i < size; ++i) step[i] = solution_[i];
    return true;
  }

 private:
  T Row(const double* rows, long row, int lane) const {
    return T::Load(rows + row * chains_.lanes + lane);
  }
  void StoreRow(const T& value, double* rows, long row, int lane) const {
    value.Store(rows + row * chains_.lanes + lane);
  }
  void Load6(const double* rows, int k, int lane, T* to) const {
    for (int i = 0; i < 6; ++i) to[i] = Row(rows, 6L * k + i, lane);
  }
  void Store6(const T* from, double* rows, int k, int lane) const {
    for (int i = 0; i < 6; ++i) StoreRow(from[i], rows, 6L * k + i, lane);
  }
  LaneAxis<T> Motion(int k, int lane) const {
    LaneAxis<T> m;
    for (int i = 0; i < 4; ++i) {
      m.a[i / 2][i % 2] = Row(motion_, 4L * k + i, lane);
    }
    return m;
  }

  LaneBlock<T> LoadBlock(const double* rows, int k, int lane) const {
    LaneBlock<T> block;
    const long row = static_cast<long>(kLaneBlockSize) * k;
    ForEachEntry([&](int i, T& entry) { entry = Row(rows, row + i, lane); },
                 block);
    return block;
  }

  void StoreBlock(const LaneBlock<T>& block, double* rows, int k,
                  int lane) const {
    const long row = static_cast<long>(kLaneBlockSize) * k;
    ForEachEntry(
        [&](int i, const T& entry) { StoreRow(entry, rows, row + i, lane); },
        block);
  }
  void ClearSums() {
    for (int lane = 0; lane < chains_.lanes; ++lane) sums_[lane] = 0.0;
  }
  void AddToSums(const T& value, int lane) const {
    StoreRow(Row(sums_, 0, lane) + value, sums_, 0, lane);
  }
  double Sum() const {
    double sum = 0.0;
    for (int lane = 0; lane < chains_.joints; ++lane) sum += sums_[lane];
    return sum;
  }

  // z = M^-1 r; returns r'z.
  double Condition() {
    for (int k = frames_; k-- > 0;) {
      for (int lane = 0; lane < chains_.lanes; lane += T::kLanes) {
        T r[6];
        Load6(residual_, k, lane, r);
        if (k + 1 < frames_) {
          T later[6];
          Load6(conditioned_, k + 1, lane, later);
          SubtractProduct(Motion(k, lane), later, r);
        }
        T gained[6];
        Multiply(LoadBlock(inverse_, k, lane), r, gained);
        Store6(gained, conditioned_, k, lane);
      }
    }
    ClearSums();
    for (int k = 0; k < frames_; ++k) {
      for (int lane = 0; lane < chains_.lanes; lane += T::kLanes) {
        T z[6];
        Load6(conditioned_, k, lane, z);
        if (k > 0) {
          T earlier[6];
          Load6(conditioned_, k - 1, lane, earlier);
          T pull[6];
          MultiplyTransposed(Motion(k - 1, lane), earlier, pull);
          T back[6];
          Multiply(LoadBlock(inverse_, k, lane), pull, back);
          for (int i = 0; i < 6; ++i) z[i] -= back[i];
          Store6(z, conditioned_, k, lane);
        }
        T r[6];
        Load6(residual_, k, lane, r);
        T sum = r[0] * z[0];
        for (int i = 1; i < 6; ++i) sum += r[i] * z[i];
        AddToSums(sum, lane);
      }
    }
    return Sum();
  }

  // d = z + turn d, and M d likewise; returns d'M d.
  double Turn(double turn) {
    ClearSums();
    for (int k = 0; k < frames_; ++k) {
      for (int lane = 0; lane < chains_.lanes; lane += T::kLanes) {
        T sum = 0.0;
        for (int i = 0; i < 6; ++i) {
          const long row = 6L * k + i;
          T d = Row(conditioned_, row, lane);
          T by_chains = Row(residual_, row, lane);
          if (turn != 0.0) {
            d += turn * Row(direction_, row, lane);
            by_chains += turn * Row(by_chains_, row, lane);
          }
          StoreRow(d, direction_, row, lane);
          StoreRow(by_chains, by_chains_, row, lane);
          sum += d * by_chains;
        }
        AddToSums(sum, lane);
      }
    }
    return Sum();
  }

  // Fills C d; returns d'C d.
  double Couple() {
    const long lanes = chains_.lanes;
    for (long i = 0; i < 3L * frames_ * lanes; ++i) by_couplings_[i] = 0.0;
    double sum = 0.0;
    for (int i = 0; i < couplings_.count; ++i) {
      const LaneCoupling& coupling = couplings_.list[i];
      const double* const d = direction_ + 6L * coupling.frame * lanes;
      double* const to = by_couplings_ + 3L * coupling.frame * lanes;
      const auto& block = coupling.block;
      double a[3];
      double b[3];
      for (int axis = 0; axis < 3; ++axis) {
        a[axis] = d[axis * lanes + coupling.a];
        b[axis] = d[axis * lanes + coupling.b];
      }
      for (int axis = 0; axis < 3; ++axis) {
        const double of_b = block[axis][0] * b[0] + block[axis][1] * b[1] +
                            block[axis][2] * b[2];
        sum += 2.0 * a[axis] * of_b;
        to[axis * lanes + coupling.a] += of_b;
        to[axis * lanes + coupling.b] += block[0][axis] * a[0] +
                                         block[1][axis] * a[1] +
                                         block[2][axis] * a[2];
      }
    }
    if (couplings_.first == nullptr) return sum;
    ClearSums();
    for (int i = 0; i < 6; ++i) {
      for (int lane = 0; lane < chains_.lanes; lane += T::kLanes) {
        T product = 0.0;
        for (int joint = 0; joint < chains_.joints; ++joint) {
          for (int j = 0; j < 6; ++j) {
            product += direction_[j * lanes + joint] *
                       Row(couplings_.first, 6L * (6L * joint + j) + i, lane);
          }
        }
        StoreRow(product, by_first_, i, lane);
        AddToSums(product * Row(direction_, i, lane), lane);
      }
    }
    return sum + Sum();
  }

  // solution += share d, r -= share (M + C) d.
  void Advance(double share) {
    for (int k = 0; k < frames_; ++k) {
      for (int i = 0; i < 6; ++i) {
        const long row = 6L * k + i;
        for (int lane = 0; lane < chains_.lanes; lane += T::kLanes) {
          T product = Row(by_chains_, row, lane);
          if (i < 3) product += Row(by_couplings_, 3L * k + i, lane);
          StoreRow(
              Row(solution_, row, lane) + share * Row(direction_, row, lane),
              solution_, row, lane);
          StoreRow(Row(residual_, row, lane) - share * product, residual_, row,
                   lane);
        }
      }
    }
    if (couplings_.first == nullptr) return;
    for (int i = 0; i < 6; ++i) {
      for (int lane = 0; lane < chains_.lanes; lane += T::kLanes) {
        StoreRow(Row(residual_, i, lane) - share * Row(by_first_, i, lane),
                 residual_, i, lane);
      }
    }
  }

  const ChainLanes& chains_;
  const LaneCouplings& couplings_;
  const int frames_;
  double* inverse_;      // P_k of chain_kernel.h
  double* motion_;       // between frames k and k + 1
  double* residual_;     // r
  double* conditioned_;  // z
  double* direction_;    // d
  double* by_chains_;    // M d
  double* solution_;
  double* by_couplings_;  // C d of the factors between positions
  double* by_first_;      // C d of the person's prior, first frame only
  double* sums_;
};

template <typename T>
bool SolveCoupledLanesWith(const ChainLanes& chains,
                           const LaneSystemRows& system,
                           const LaneCouplings& couplings, double damping,
                           double accuracy, double* workspace, double* step) {
  CoupledSolve<T> solve(chains, couplings, workspace);
  if (!solve.Factorise(system.diagonal, damping)) return false;
  return solve.Solve(system.gradient, accuracy, step);
}

template <typename T>
constexpr LaneKernels LaneKernelsOf() {
  return {SolveChainLanesWith<T>, CovarianceChainLanesWith<T>,
          LineariseChainLanesWith<T>, WeighChainLanesWith<T>,
          SolveCoupledLanesWith<T>};
}

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_COUPLED_KERNEL_H_
