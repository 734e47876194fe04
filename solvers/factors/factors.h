// The types of factors, and the iteration over the factors of a joint, for one
// joint or a pack of joints. Uses no Eigen and does not allocate (jacobian.h).
#ifndef KINEGRAPH_SOLVERS_FACTORS_FACTORS_H_
#define KINEGRAPH_SOLVERS_FACTORS_FACTORS_H_

#include <algorithm>
#include <cmath>

#include "core/base/pack.h"
#include "solvers/factors/jacobian.h"

namespace kinegraph {

// Smallest depth at which a joint is measured [m]. For smaller depths the
// information of a pixel would grow beyond any detector's accuracy.
inline constexpr double kNearestDepthM = 0.1;

// A joint's pixel in one view:
// r = (project(view, p + offset v) - u) / sigma_px                       [2]
//
// Key: state [p; v] [m, m/s]. u (`px`) is a raw pixel; `project` includes the
// lens. `offset_s` is the view's own capture time minus the frame's time. The
// sigma is constant: a state-dependent one would lower the cost of states that
// increase it.
// Evaluate returns false where View::Project does: if the point cannot be
// projected, because it is nearer than kNearestDepthM, behind the camera or
// outside the lens's region. (A View over packs returns true and reports this
// by lane.) Solvers gate such measurements at their start. A single view does
// not determine the depth.
//
// View has bool Project(const T* point, T* px, T (*by_point)[3]) const;
// `by_point`, 2x3 [px/m], may be null.
template <typename T, typename View>
struct Reprojection {
  static constexpr int kResiduals = 2;
  static constexpr int kKeys = 1;
  using Jacobian = PointJacobian<kResiduals, T>;

  View view;
  double offset_s;
  T px[2];
  T per_sigma;  // 1/px

  bool Evaluate(const T* const (&states)[kKeys], T* residual,
                Jacobian* by_states) const {
    T point[3];
    PointAt(states[0], offset_s, point);
    T image[2];
    if (!view.Project(point, image,
                      by_states == nullptr ? nullptr : by_states->by_point)) {
      return false;
    }
    for (int row = 0; row < kResiduals; ++row) {
      residual[row] = per_sigma * (image[row] - px[row]);
    }
    if (by_states == nullptr) return true;
    by_states->offset_s = offset_s;
    for (int row = 0; row < kResiduals; ++row) {
      for (int i = 0; i < 3; ++i) {
        by_states->by_point[row][i] = per_sigma * by_states->by_point[row][i];
      }
    }
    return true;
  }
};

// Weak prior that keeps a joint near its person:
// r = (p - centre) / sigma                                               [3]
//
// Key: state [p; v] [m, m/s]. Without it a joint seen by fewer than two views
// would drift with the motion model: through the floor, or along the ray
// towards the camera, where the information of a pixel is unbounded. The centre
// [m] is given; sigma [m] is so large that the effect on joints seen by two
// views is negligible.
template <typename T>
struct BodyCentre {
  static constexpr int kResiduals = 3;
  static constexpr int kKeys = 1;
  using Jacobian = PointJacobian<kResiduals, T>;

  const double* centre_m;  // [3]; must outlive the factor
  double per_sigma;        // 1/m

  bool Evaluate(const T* const (&states)[kKeys], T* residual,
                Jacobian* by_states) const {
    for (int i = 0; i < 3; ++i) {
      residual[i] = per_sigma * (states[0][i] - T(centre_m[i]));
    }
    if (by_states == nullptr) return true;
    for (int row = 0; row < 3; ++row) {
      for (int i = 0; i < 3; ++i) {
        by_states->by_point[row][i] = T(row == i ? per_sigma : 0.0);
      }
    }
    by_states->offset_s = 0.0;
    return true;
  }
};

// Motion of a joint between two frames:
// r = L^-1 [p1 - p0 - dt v0; v1 - v0]                                    [6]
//
// L L' = Q(dt) = q [dt^3/3, dt^2/2; dt^2/2, dt] for each axis. Keys: states [p;
// v] [m, m/s] of one joint in two frames dt apart. White noise on acceleration
// with power q: Anderson and Barfoot, "Full STEAM ahead" (IROS 2015); Barfoot,
// State Estimation for Robotics, ch. 11. Valid for any dt, so gaps and dropped
// frames need no filling. Alone it leaves the common position and velocity of a
// chain free: a chain needs a prior.
template <typename T>
class ConstantVelocity {
 public:
  static constexpr int kResiduals = kStateSize;
  static constexpr int kKeys = 2;
  using Jacobian = AxisJacobian<T>;

  ConstantVelocity() = default;  // assigned later
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
  T pp_;  // entries of L^-1, which is lower triangular [1/m]
  T vp_;  // [1/m]
  T vv_;  // [s/m]
};

// The distance between the two ends of a bone:
// r = (|p_a - p_b| - length) / sigma                                     [1]
//
// Keys: states [p; v] [m, m/s] of the bone's ends in one frame; length and
// sigma > 0 [m]. Where the ends coincide the direction is undefined: the
// residual is valid, the Jacobian is zero, and other factors must separate the
// ends.
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

  // A stretched bone also resists rotation, which Gauss-Newton ignores: with J
  // the Jacobian by one end, half the squared residual has the second
  // derivative J'J + s (1 / sigma^2 - J'J), s = r sigma / |p_a - p_b|. Returns
  // s, or 0 for a compressed bone, whose s is negative.
  T Swing(const T& residual) const {
    using std::max;
    const T stretched = max(residual, T(0.0));
    return stretched / (per_sigma * length_m + stretched);
  }
};

// Prior on one state, from before any measurement or from frames that left a
// window:
// r = A (x - x0) + b                                                     [6]
//
// Key: state x = [p; v] [m, m/s]. A is a square root of the information (A'A),
// upper triangular, stored column by column; b is the residual at x0. The
// caller owns all three, which must outlive the factor.
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

// Iterates over the factors of a joint. The caller supplies a chain, which
// creates each factor from its own numbers (doubles in
// solvers/graph/factor_list.h, packs in
// solvers/block_tridiagonal/chain_kernel.h), and a visitor that accepts every
// type of factor: one that a chain or a visitor does not handle is a compile
// error.
//
// Visits the factors whose earliest state is that of frame k, as
//   bool visit(factor, counting)
// on the states of frames k .. k + Factor::kKeys - 1; returning false ends the
// iteration. `counting` is what the visitor needs besides the factor to weight
// it, of a type that the chain defines. A chain has
//   frame_count()
//   HasPrior(), Prior()           on the state of frame 0
//   HasCentre(k), Centre(k)       on the state of frame k
//   Motion(k)                     from frame k to frame k + 1
//   PixelsBegin(k), PixelsEnd(k)  the measurements of frame k
//   IsLeftOut(m), Pixel(m)        of measurement m
//   Always(), CountingOf(m)       the `counting` of any other factor, and of
//                                 measurement m
template <typename Chain, typename Frame, typename Visit>
KINEGRAPH_INLINE bool ForEachFactorOfFrame(const Chain& chain, Frame k,
                                           Visit&& visit) {
  if (k == 0 && chain.HasPrior() && !visit(chain.Prior(), chain.Always())) {
    return false;
  }
  if (chain.HasCentre(k) && !visit(chain.Centre(k), chain.Always())) {
    return false;
  }
  if (k + 1 < chain.frame_count() && !visit(chain.Motion(k), chain.Always())) {
    return false;
  }
  for (auto m = chain.PixelsBegin(k); m < chain.PixelsEnd(k); ++m) {
    if (chain.IsLeftOut(m)) continue;
    if (!visit(chain.Pixel(m), chain.CountingOf(m))) return false;
  }
  return true;
}

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FACTORS_FACTORS_H_
