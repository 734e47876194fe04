#include "core/geometry/epipolar.h"

#include <Eigen/LU>
#include <cmath>

#include "core/geometry/dlt_kernel.h"

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
  const EpipolarTerms<double> terms(fundamental(view_a, view_b), a_px.x(),
                                    a_px.y(), b_px.x(), b_px.y());
  if (!(terms.norm_a > 0.0) || !(terms.norm_b > 0.0)) return 0.0;
  // residual (weight_a / |l_a| + weight_b / |l_b|) / 2 with one division; l_a
  // is the line in view a, so a's distance is measured from it.
  const double length_a = std::sqrt(terms.norm_a);
  const double length_b = std::sqrt(terms.norm_b);
  return 0.5 * terms.residual * (weight_a * length_b + weight_b * length_a) /
         (length_a * length_b);
}

}  // namespace kinegraph
