// World -> camera -> lens -> pixels, for single points and for packs.
//
// Plain numbers and no Eigen, so that files compiled for wider instruction sets
// may use it (core/base/pack.h). Camera::Project calls Project with T = double.
#ifndef KINEGRAPH_CORE_GEOMETRY_PROJECTION_H_
#define KINEGRAPH_CORE_GEOMETRY_PROJECTION_H_

#include "core/base/pack.h"

namespace kinegraph {

// A lens as plain numbers (core/geometry/lens.h). To add a model, add a kind
// here and its formula in Distort.
enum class LensKind { kNone, kOpenCv5, kFisheye };
struct LensModel {
  LensKind kind = LensKind::kNone;  // none: an ideal pinhole
  double k1 = 0.0, k2 = 0.0, p1 = 0.0, p2 = 0.0, k3 = 0.0;
  double k4 = 0.0;  // kFisheye, which has no p1 and p2
  // One-to-one up to this squared distance from the axis (dimensionless).
  double max_radius_squared = 0.0;
};

// A camera as plain numbers.
struct CameraModel {
  double R[3][3] = {};  // cam_from_world
  double t[3] = {};     // cam_from_world [m]
  // K: focal lengths, skew and principal point [px].
  double fx = 1.0, skew = 0.0, fy = 1.0, cx = 0.0, cy = 0.0;
  LensModel lens;
};

// Distorted point of the ideal one (x, y), normalised coordinates, by OpenCV's
// five coefficients k1 k2 p1 p2 k3:
//   x' = x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2)
//   y' = y (1 + k1 r^2 + k2 r^4 + k3 r^6) + p1 (r^2 + 2 y^2) + 2 p2 x y
// `jacobian`, if not null, receives d (x', y') / d (x, y) as xx, xy, yy: it is
// symmetric.
template <typename T>
KINEGRAPH_INLINE void DistortOpenCv5(const LensModel& lens, const T& x,
                                     const T& y, T* distorted_x, T* distorted_y,
                                     T* jacobian) {
  const T r2 = x * x + y * y;
  const T radial = 1.0 + r2 * (lens.k1 + r2 * (lens.k2 + r2 * lens.k3));
  if (jacobian != nullptr) {
    // d radial / d r2
    const T slope = lens.k1 + r2 * (2.0 * lens.k2 + r2 * 3.0 * lens.k3);
    jacobian[0] =
        radial + 2.0 * x * x * slope + 2.0 * lens.p1 * y + 6.0 * lens.p2 * x;
    jacobian[1] = 2.0 * x * y * slope + 2.0 * lens.p1 * x + 2.0 * lens.p2 * y;
    jacobian[2] =
        radial + 2.0 * y * y * slope + 6.0 * lens.p1 * y + 2.0 * lens.p2 * x;
  }
  *distorted_x =
      x * radial + 2.0 * lens.p1 * x * y + lens.p2 * (r2 + 2.0 * x * x);
  *distorted_y =
      y * radial + lens.p1 * (r2 + 2.0 * y * y) + 2.0 * lens.p2 * x * y;
}

// The distorted point by OpenCV's fisheye model (Kannala and Brandt 2006,
// symmetric part): a ray at the angle a = atan(r) off the axis is imaged at the
// radius
//   r' = a (1 + k1 a^2 + k2 a^4 + k3 a^6 + k4 a^8)
// in the direction of (x, y).
template <typename T>
KINEGRAPH_INLINE void DistortFisheye(const LensModel& lens, const T& x,
                                     const T& y, T* distorted_x, T* distorted_y,
                                     T* jacobian) {
  const T r2 = x * x + y * y;
  // Below this r' / r = 1 + (k1 - 1/3) r^2 to rounding; at r = 0 the quotients
  // of the closed form are 0 / 0.
  const auto small = r2 < T(1e-8);
  const T safe_r2 = Select(small, T(1.0), r2);
  const T r = Sqrt(safe_r2);
  const T a = Atan(r);
  const T s = a * a;
  const T bent =
      a * (1.0 + s * (lens.k1 + s * (lens.k2 + s * (lens.k3 + s * lens.k4))));
  const double first = lens.k1 - 1.0 / 3.0;
  const T scale = Select(small, 1.0 + first * r2, bent / r);
  if (jacobian != nullptr) {
    // d r' / d r
    const T radial =
        (1.0 +
         s * (3.0 * lens.k1 +
              s * (5.0 * lens.k2 + s * (7.0 * lens.k3 + s * 9.0 * lens.k4)))) /
        (1.0 + safe_r2);
    const T slope = Select(small, T(2.0 * first), (radial - scale) / safe_r2);
    jacobian[0] = scale + x * x * slope;
    jacobian[1] = x * y * slope;
    jacobian[2] = scale + y * y * slope;
  }
  *distorted_x = x * scale;
  *distorted_y = y * scale;
}

// Distorts by the formula of the lens' kind, which must not be kNone.
template <typename T>
KINEGRAPH_INLINE void Distort(const LensModel& lens, const T& x, const T& y,
                              T* distorted_x, T* distorted_y, T* jacobian) {
  if (lens.kind == LensKind::kFisheye) {
    DistortFisheye(lens, x, y, distorted_x, distorted_y, jacobian);
  } else {
    DistortOpenCv5(lens, x, y, distorted_x, distorted_y, jacobian);
  }
}

// Whether the lens is one-to-one at the ideal point (x, y).
template <typename T>
KINEGRAPH_INLINE Mask<T> InDomain(const LensModel& lens, const T& x,
                                  const T& y) {
  return x * x + y * y <= T(lens.max_radius_squared);
}

// Raw pixel (u, v) of a world point [m]. `jacobian`, if not null, receives d
// (u, v) / d point, 2x3 by rows [px/m]. The mask is true where the point has an
// image: in front of the camera and inside the lens' region. Elsewhere the
// outputs are meaningless.
template <typename T>
KINEGRAPH_INLINE Mask<T> Project(const CameraModel& camera, const T point[3],
                                 T* u, T* v, T* jacobian) {
  const bool has_lens = camera.lens.kind != LensKind::kNone;
  const auto& R = camera.R;
  const T z = R[2][0] * point[0] + R[2][1] * point[1] + R[2][2] * point[2] +
              camera.t[2];
  Mask<T> visible = z > T(0.0);
  // A divisor of 1 keeps the meaningless outputs of other points finite.
  const T inverse_z = 1.0 / Select(visible, z, T(1.0));
  const T x = (R[0][0] * point[0] + R[0][1] * point[1] + R[0][2] * point[2] +
               camera.t[0]) *
              inverse_z;
  const T y = (R[1][0] * point[0] + R[1][1] * point[1] + R[1][2] * point[2] +
               camera.t[1]) *
              inverse_z;
  T distorted_x = x;
  T distorted_y = y;
  T d_lens[3] = {T(1.0), T(0.0), T(1.0)};
  if (has_lens) {
    visible = And(visible, InDomain(camera.lens, x, y));
    Distort(camera.lens, x, y, &distorted_x, &distorted_y,
            jacobian == nullptr ? nullptr : d_lens);
  }
  *u = camera.fx * distorted_x + camera.skew * distorted_y + camera.cx;
  *v = camera.fy * distorted_y + camera.cy;
  // Written so that NaN counts as no image.
  const T kHuge = 1e300;
  visible = And(visible, And(Abs(*u) < kHuge, Abs(*v) < kHuge));
  if (jacobian == nullptr) return visible;
  // d pixel / d ideal point, times 1 / z.
  T ux = camera.fx * inverse_z;
  T uy = camera.skew * inverse_z;
  T vx = T(0.0);
  T vy = camera.fy * inverse_z;
  if (has_lens) {
    const T sx = ux;
    const T sy = uy;
    ux = sx * d_lens[0] + sy * d_lens[1];
    uy = sx * d_lens[1] + sy * d_lens[2];
    vx = vy * d_lens[1];
    vy = vy * d_lens[2];
  }
  // d ideal / d point in the camera frame is [1, 0, -x; 0, 1, -y] / z.
  const T uz = -(ux * x + uy * y);
  const T vz = -(vx * x + vy * y);
  for (int i = 0; i < 3; ++i) {
    jacobian[i] = ux * R[0][i] + uy * R[1][i] + uz * R[2][i];
    jacobian[3 + i] = vx * R[0][i] + vy * R[1][i] + vz * R[2][i];
  }
  return visible;
}

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_GEOMETRY_PROJECTION_H_
