// How a joint moves between two frames.
#ifndef KINEGRAPH_SOLVERS_FACTORS_CONSTANT_VELOCITY_H_
#define KINEGRAPH_SOLVERS_FACTORS_CONSTANT_VELOCITY_H_

#include <cmath>

#include "solvers/factors/jacobian.h"

namespace kinegraph {

// r = L^-1 [p1 - p0 - dt v0; v1 - v0]                                    [6]
//
// L L' = Q(dt) = q [dt^3/3, dt^2/2; dt^2/2, dt] for each axis. Keys: states
// [p; v] [m, m/s] of one joint in two frames dt apart. White noise on
// acceleration with power q: Anderson and Barfoot, "Full STEAM ahead" (IROS
// 2015); Barfoot, State Estimation for Robotics, ch. 11. Holds for any dt, so
// gaps and dropped frames need no filling. Alone it leaves the common position
// and velocity of a chain free: a chain needs a prior.
template <typename T>
class ConstantVelocity {
 public:
  static constexpr int kResiduals = kStateSize;
  static constexpr int kKeys = 2;
  using Jacobian = AxisJacobian<T>;

  ConstantVelocity() = default;  // to be assigned to
  // dt_s > 0 [s], q > 0 [m^2/s^3].
  ConstantVelocity(double dt_s, T q) : dt_s_(dt_s) {
    using std::sqrt;
    // L = sqrt(q dt) [dt / sqrt 3, 0; sqrt 3 / 2, 1 / 2].
    constexpr double kRootThree = 1.7320508075688772;
    const T per_root = T(1.0) / sqrt(q * T(dt_s));
    pp_ = (kRootThree / dt_s) * per_root;
    vp_ = (-3.0 / dt_s) * per_root;
    vv_ = 2.0 * per_root;
  }

  bool Evaluate(const T* const (&states)[kKeys], T* residual,
                Jacobian* by_states) const {
    const T* from = states[0];
    const T* to = states[1];
    for (int i = 0; i < 3; ++i) {
      const T position = to[i] - from[i] - dt_s_ * from[i + 3];
      residual[i] = pp_ * position;
      residual[i + 3] = vp_ * position + vv_ * (to[i + 3] - from[i + 3]);
    }
    if (by_states == nullptr) return true;
    by_states[0] = {{{-pp_, -dt_s_ * pp_}, {-vp_, -dt_s_ * vp_ - vv_}}};
    by_states[1] = {{{pp_, T(0.0)}, {vp_, vv_}}};
    return true;
  }

 private:
  double dt_s_;
  T pp_;  // of L^-1 [1/m], lower triangular
  T vp_;
  T vv_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FACTORS_CONSTANT_VELOCITY_H_
