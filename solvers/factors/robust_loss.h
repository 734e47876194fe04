// The formulas of the robust losses (see loss.h) for doubles and packs. Uses no
// Eigen, because the kernels of solvers/block_tridiagonal include it.
#ifndef KINEGRAPH_SOLVERS_FACTORS_ROBUST_LOSS_H_
#define KINEGRAPH_SOLVERS_FACTORS_ROBUST_LOSS_H_

#include "core/base/pack.h"
#include "solvers/factors/loss_kind.h"

namespace kinegraph {

template <typename T>
struct LossTerms {
  T rho;
  T first;   // d rho / d s: the weight of an observation, 0 .. 1
  T second;  // d^2 rho / d s^2, never positive
};

// `scale` > 0 [sigmas], `s` >= 0.
template <typename T>
KINEGRAPH_INLINE LossTerms<T> LossAt(LossKind kind, double scale, const T& s) {
  const double c2 = scale * scale;
  switch (kind) {
    case LossKind::kNone:
      break;
    case LossKind::kHuber: {
      const Mask<T> inside = s <= T(c2);
      const T root = Sqrt(Select(inside, T(c2), s));
      const T weight = scale / root;
      return {Select(inside, s, 2.0 * scale * root - c2),
              Select(inside, T(1.0), weight),
              Select(inside, T(0.0), -0.5 * weight / (root * root))};
    }
    case LossKind::kCauchy: {
      const T weight = 1.0 / (1.0 + s / c2);
      return {c2 * Log1p(s / c2), weight, -(weight * weight) / c2};
    }
    case LossKind::kGemanMcClure: {
      const T share = c2 / (c2 + s);
      return {s * share, share * share, -2.0 * share * share / (c2 + s)};
    }
    case LossKind::kTukey: {
      const T rest = Max(T(0.0), 1.0 - s / c2);
      return {c2 / 3.0 * (1.0 - rest * rest * rest), rest * rest,
              -2.0 * rest / c2};
    }
  }
  return {s, T(1.0), T(0.0)};
}

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FACTORS_ROBUST_LOSS_H_
