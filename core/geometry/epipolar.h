// Epipolar geometry of a rig: tests whether points of two views can be images
// of one world point.
#ifndef KINEGRAPH_CORE_GEOMETRY_EPIPOLAR_H_
#define KINEGRAPH_CORE_GEOMETRY_EPIPOLAR_H_

#include <Eigen/Core>
#include <vector>

#include "core/geometry/camera.h"

namespace kinegraph {

// F with x_b^T F x_a = 0 for the ideal pixels x_a, x_b of one world point
// (Hartley and Zisserman, Multiple View Geometry, section 9.2). Zero when the
// two camera centres coincide.
Eigen::Matrix3d FundamentalMatrix(const Camera& a, const Camera& b);

// The fundamental matrices of all pairs of views, computed once.
class EpipolarGeometry {
 public:
  explicit EpipolarGeometry(const CameraRig& cameras);

  // Mean of the two distances [px] between each point and the epipolar line of
  // the other (Chu et al. 2021, Eq. 2), from ideal pixels. Zero where the lines
  // are undefined (a point on the epipole), which is no conflict.
  double Distance(int view_a, const Eigen::Vector2d& a_px, int view_b,
                  const Eigen::Vector2d& b_px) const {
    return WeightedDistance(view_a, a_px, 1.0, view_b, b_px, 1.0);
  }

  // F of the pair by columns, for core/geometry/dlt_lanes.h.
  const double* fundamental(int view_a, int view_b) const {
    return fundamental_[view_a * view_count_ + view_b].data();
  }

  // (weight_a d_a + weight_b d_b) / 2 with d_a the distance of a from the line
  // of b [px]; the weights are not normalised.
  double WeightedDistance(int view_a, const Eigen::Vector2d& a_px,
                          double weight_a, int view_b,
                          const Eigen::Vector2d& b_px, double weight_b) const;

 private:
  int view_count_;
  std::vector<Eigen::Matrix3d> fundamental_;  // [a * view_count_ + b]
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_GEOMETRY_EPIPOLAR_H_
