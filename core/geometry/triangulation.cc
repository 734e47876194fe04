#include "core/geometry/triangulation.h"

#include <Eigen/SVD>
#include <cmath>

#include "core/geometry/dlt_kernel.h"

namespace kinegraph {
namespace {

// The unit vector X that minimises |A X|; by an SVD of R where the iteration of
// SmallestSingularVector does not converge.
Eigen::Vector4d Solve(RowReducer<double>* rows) {
  rows->Reduce();
  Eigen::Vector4d vector;
  if (SmallestSingularVector(*rows, vector.data())) return vector;
  Eigen::Matrix4d R = Eigen::Matrix4d::Zero();
  for (int r = 0; r < 4; ++r) {
    for (int c = r; c < 4; ++c) R(r, c) = rows->R(r, c);
  }
  const Eigen::JacobiSVD<Eigen::Matrix4d> svd(R, Eigen::ComputeFullV);
  return svd.matrixV().col(3);
}

// Measurements of weight 0 did not contribute to the point and are ignored.
bool HasParallax(Span<PointMeasurement> measurements,
                 const Eigen::Vector3d& point, double min_angle_rad) {
  ParallaxTest<double> parallax(min_angle_rad);
  for (const PointMeasurement& m : measurements) {
    parallax.Add(m.camera->centre().data(), point.data(), m.weight > 0.0);
  }
  return parallax.passed();
}

}  // namespace

TriangulationResult TriangulateDlt(Span<PointMeasurement> measurements,
                                   const TriangulationOptions& options) {
  TriangulationResult result;
  RowReducer<double> rows;
  int used = 0;
  for (const PointMeasurement& m : measurements) {
    if (!std::isfinite(m.ideal_px.x()) || !std::isfinite(m.ideal_px.y()) ||
        !std::isfinite(m.weight)) {
      result.status = TriangulationStatus::kNotFinite;
      return result;
    }
    if (!(m.weight > 0.0)) continue;
    ++used;
    rows.Add(m.camera->P().data(), m.ideal_px.x(), 0, m.weight);
    rows.Add(m.camera->P().data(), m.ideal_px.y(), 1, m.weight);
  }
  if (used < 2) return result;
  const Eigen::Vector4d homogeneous = Solve(&rows);
  result.point_m = homogeneous.head<3>() / homogeneous(3);
  if (!result.point_m.allFinite()) {
    // The homogeneous solution is a direction: the rays meet at infinity.
    result.status = homogeneous.allFinite() ? TriangulationStatus::kParallelRays
                                            : TriangulationStatus::kNotFinite;
    return result;
  }
  if (!HasParallax(measurements, result.point_m, options.min_angle_rad)) {
    result.status = TriangulationStatus::kParallelRays;
    return result;
  }
  for (const PointMeasurement& m : measurements) {
    if (!options.require_in_front) break;
    if (m.weight > 0.0 && !(m.camera->Depth(result.point_m) > 0.0)) {
      result.status = TriangulationStatus::kBehindCamera;
      return result;
    }
  }
  result.status = TriangulationStatus::kOk;
  return result;
}

}  // namespace kinegraph
