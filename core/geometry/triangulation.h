// One point from several views.
#ifndef KINEGRAPH_CORE_GEOMETRY_TRIANGULATION_H_
#define KINEGRAPH_CORE_GEOMETRY_TRIANGULATION_H_

#include <Eigen/Core>

#include "core/base/span.h"
#include "core/geometry/camera.h"
#include "core/geometry/dlt_lanes.h"

namespace kinegraph {

enum class TriangulationStatus {
  kOk,
  kTooFewViews,   // fewer than two measurements with a positive weight
  kNotFinite,     // a measurement or the unit vector X is not finite
  kParallelRays,  // no ray differs from the first by the minimum angle, or X is
                  // a point at infinity
  kBehindCamera,  // the point is behind a camera that measured it
};

struct PointMeasurement {
  const Camera* camera = nullptr;
  Eigen::Vector2d ideal_px = Eigen::Vector2d::Zero();
  double weight = 1.0;  // of the equations, whose squared errors are summed
};

struct TriangulationResult {
  TriangulationStatus status = TriangulationStatus::kTooFewViews;
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();  // valid if kOk
  bool ok() const { return status == TriangulationStatus::kOk; }
};

// Direct linear transformation: the unit vector X that minimises |A X|. Each
// view gives two rows, u p3 - p1 and v p3 - p2 (Hartley and Zisserman, section
// 12.2), each normalised and multiplied by the weight.
TriangulationResult TriangulateDlt(Span<PointMeasurement> measurements,
                                   const TriangulationOptions& options = {});

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_GEOMETRY_TRIANGULATION_H_
