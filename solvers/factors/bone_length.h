// The distance of two joints of one bone.
#ifndef KINEGRAPH_SOLVERS_FACTORS_BONE_LENGTH_H_
#define KINEGRAPH_SOLVERS_FACTORS_BONE_LENGTH_H_

#include <algorithm>
#include <cmath>

#include "solvers/factors/jacobian.h"

namespace kinegraph {

// r = (|p_a - p_b| - length) / sigma                                     [1]
//
// Keys: states [p; v] [m, m/s] of the bone's ends in one frame; length and
// sigma > 0 [m]. Where the ends coincide the direction is undefined: the
// residual stands, the Jacobian is zero, and other factors must part them.
template <typename T>
struct BoneLength {
  static constexpr int kResiduals = 1;
  static constexpr int kKeys = 2;
  using Jacobian = PointJacobian<kResiduals, T>;

  T length_m;
  T per_sigma;  // 1/m

  bool Evaluate(const T* const (&states)[kKeys], T* residual,
                Jacobian* by_states) const {
    using std::max;
    using std::sqrt;
    const T bone[3] = {states[0][0] - states[1][0], states[0][1] - states[1][1],
                       states[0][2] - states[1][2]};
    const T length =
        sqrt(bone[0] * bone[0] + bone[1] * bone[1] + bone[2] * bone[2]);
    residual[0] = per_sigma * (length - length_m);
    if (by_states == nullptr) return true;
    constexpr double kCoincident = 1e-9;  // m
    const T scale = per_sigma / max(length, T(kCoincident));
    for (int i = 0; i < 3; ++i) {
      by_states[0].by_point[0][i] = scale * bone[i];
      by_states[1].by_point[0][i] = -(scale * bone[i]);
    }
    by_states[0].offset_s = by_states[1].offset_s = 0.0;
    return true;
  }

  // A stretched bone also resists what turns it, which Gauss-Newton does not
  // see: with J the Jacobian by one end, half the squared residual has the
  // second derivative J'J + s (1 / sigma^2 - J'J), s = r sigma / |p_a - p_b|.
  // Returns s, or 0 for a bone that is too short: there it is negative.
  T Swing(const T& residual) const {
    using std::max;
    const T stretched = max(residual, T(0.0));
    return stretched / (per_sigma * length_m + stretched);
  }
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FACTORS_BONE_LENGTH_H_
