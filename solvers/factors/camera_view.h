// A camera as reprojections of doubles see it.
#ifndef KINEGRAPH_SOLVERS_FACTORS_CAMERA_VIEW_H_
#define KINEGRAPH_SOLVERS_FACTORS_CAMERA_VIEW_H_

#include <optional>

#include "core/geometry/camera.h"
#include "solvers/factors/reprojection.h"

namespace kinegraph {

struct CameraView {
  const Camera* camera = nullptr;  // outlives the factor

  bool Project(const double* point, double* px, double (*by_point)[3]) const {
    Matrix23d jacobian;
    const std::optional<Eigen::Vector2d> image =
        camera->Project(Eigen::Vector3d(point[0], point[1], point[2]),
                        by_point == nullptr ? nullptr : &jacobian);
    if (!image.has_value()) return false;
    for (int row = 0; row < 2; ++row) {
      px[row] = (*image)(row);
      if (by_point == nullptr) continue;
      for (int i = 0; i < 3; ++i) by_point[row][i] = jacobian(row, i);
    }
    return true;
  }
};

using CameraReprojection = Reprojection<double, CameraView>;

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FACTORS_CAMERA_VIEW_H_
