#include "core/geometry/epipolar.h"

#include <Eigen/LU>
#include <cmath>

namespace kinegraph {

Eigen::Matrix3d FundamentalMatrix(const Camera& a, const Camera& b) {
  const Eigen::Matrix3d b_from_a = b.R() * a.R().transpose();
  const Eigen::Vector3d t = b.t() - b_from_a * a.t();
  Eigen::Matrix3d cross;
  cross << 0.0, -t.z(), t.y(), t.z(), 0.0, -t.x(), -t.y(), t.x(), 0.0;
  return b.K().inverse().transpose() * cross * b_from_a * a.K().inverse();
}

EpipolarGeometry::EpipolarGeometry(const CameraRig& cameras)
    : view_count_(static_cast<int>(cameras.size())) {
  fundamental_.reserve(cameras.size() * cameras.size());
  for (const Camera& a : cameras) {
    for (const Camera& b : cameras) {
      fundamental_.push_back(FundamentalMatrix(a, b));
    }
  }
}

double EpipolarGeometry::WeightedDistance(int view_a,
                                          const Eigen::Vector2d& a_px,
                                          double weight_a, int view_b,
                                          const Eigen::Vector2d& b_px,
                                          double weight_b) const {
  // Scalar code: this is the innermost loop of the joints filter and of
  // initialisation.
  const double* f = fundamental_[view_a * view_count_ + view_b].data();
  const double ax = a_px.x();
  const double ay = a_px.y();
  const double bx = b_px.x();
  const double by = b_px.y();
  // Line of a in view b: F x_a; line of b in view a: F^T x_b. F is stored by
  // columns.
  const double in_b_x = f[0] * ax + f[3] * ay + f[6];
  const double in_b_y = f[1] * ax + f[4] * ay + f[7];
  const double in_b_z = f[2] * ax + f[5] * ay + f[8];
  const double in_a_x = f[0] * bx + f[1] * by + f[2];
  const double in_a_y = f[3] * bx + f[4] * by + f[5];
  const double residual =
      std::abs(bx * in_b_x + by * in_b_y + in_b_z);  // x_b^T F x_a
  const double norm_b = in_b_x * in_b_x + in_b_y * in_b_y;
  const double norm_a = in_a_x * in_a_x + in_a_y * in_a_y;
  if (!(norm_a > 0.0) || !(norm_b > 0.0)) return 0.0;
  // residual (weight_a / |l_a| + weight_b / |l_b|) / 2 with one division; l_a
  // is the line in view a, so a's distance is measured from it.
  const double length_a = std::sqrt(norm_a);
  const double length_b = std::sqrt(norm_b);
  return 0.5 * residual * (weight_a * length_b + weight_b * length_a) /
         (length_a * length_b);
}

}  // namespace kinegraph
