#include "solvers/cameras/world_motion.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/base/constants.h"
#include "core/geometry/triangulation.h"

namespace kinegraph {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// The point with the least sum of squared distances to the optical axes.
std::optional<Vector3d> LookedAt(const CameraRig& cameras) {
  Matrix3d information = Matrix3d::Zero();
  Vector3d pull = Vector3d::Zero();
  for (const Camera& camera : cameras) {
    const Vector3d axis = camera.R().row(2);
    const Matrix3d across = Matrix3d::Identity() - axis * axis.transpose();
    information += across;
    pull += across * camera.centre();
  }
  // If axes differ by an angle a, the smallest eigenvalue is about a^2 / 2.
  constexpr double kLeast = 1e-3;  // about three degrees
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(information);
  if (!(solver.eigenvalues()[0] > kLeast)) return std::nullopt;
  return Vector3d(information.inverse() * pull);
}

// The point that the cameras `after` triangulate from the pixels at which the
// cameras `before` see `point_m`; nullopt if there is none.
std::optional<Vector3d> SeenBy(const CameraRig& before, const CameraRig& after,
                               const Vector3d& point_m) {
  std::vector<PointMeasurement> measurements;
  for (size_t c = 0; c < before.size(); ++c) {
    const auto raw_px = before[c].Project(point_m);
    if (!raw_px) continue;
    const auto ideal_px = after[c].Undistort(*raw_px);
    if (ideal_px) measurements.push_back({&after[c], *ideal_px, 1.0});
  }
  const TriangulationResult seen = TriangulateDlt(measurements);
  if (!seen.ok()) return std::nullopt;
  return seen.point_m;
}

}  // namespace

std::optional<WorldMotion> WorldMotionOf(const CameraRig& before,
                                         const CameraRig& after) {
  const std::optional<Vector3d> middle = LookedAt(before);
  if (!middle) return std::nullopt;
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const Camera& camera : before) {
    nearest_m = std::min(nearest_m, (camera.centre() - *middle).norm());
  }
  const double half_edge_m = 0.25 * nearest_m;
  std::vector<Vector3d> from, to;
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        const Vector3d point = *middle + half_edge_m * Vector3d(x, y, z);
        const auto moved = SeenBy(before, after, point);
        if (!moved) continue;
        from.push_back(point);
        to.push_back(*moved);
      }
    }
  }
  constexpr size_t kFewest = 9;  // of 27 points; never collinear
  if (from.size() < kFewest) return std::nullopt;
  Eigen::Matrix3Xd old_points(3, from.size()), new_points(3, from.size());
  WorldMotion motion;
  for (size_t i = 0; i < from.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    old_points.col(column) = from[i];
    new_points.col(column) = to[i];
    motion.moved_m +=
        (to[i] - from[i]).norm() / static_cast<double>(from.size());
  }
  const Matrix3d scaled =
      Eigen::umeyama(old_points, new_points, true).topLeftCorner<3, 3>();
  motion.scale = std::cbrt(scaled.determinant());
  motion.turned_deg =
      kDegPerRad * Eigen::AngleAxisd(Matrix3d(scaled / motion.scale)).angle();
  return motion;
}

}  // namespace kinegraph
