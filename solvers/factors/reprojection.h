// A joint's pixel in one view.
#ifndef KINEGRAPH_SOLVERS_FACTORS_REPROJECTION_H_
#define KINEGRAPH_SOLVERS_FACTORS_REPROJECTION_H_

#include "solvers/factors/jacobian.h"

namespace kinegraph {

// r = (project(view, p + offset v) - u) / sigma_px                       [2]
//
// Key: state [p; v] [m, m/s]. `px` u is a raw pixel, the lens is inside
// `project`. `offset_s` is the view's own capture time less the frame's time.
// The sigma is constant: one that depended on the state would reward drifting
// away. Evaluate is false where the point has no image: behind the camera or
// outside the lens' region; such a start is gated when a problem is assembled.
// One view leaves the depth free.
//
// View has bool Project(const T* point, T* px, T (*by_point)[3]) const;
// `by_point`, 2x3 [px/m], may be null.
template <typename T, typename View>
struct Reprojection {
  static constexpr int kResiduals = 2;
  static constexpr int kKeys = 1;
  using Jacobian = PointJacobian<kResiduals, T>;

  View view;
  T px[2];
  T per_sigma;  // 1/px
  double offset_s = 0.0;

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

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FACTORS_REPROJECTION_H_
