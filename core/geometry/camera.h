// A calibrated camera: world -> camera -> lens -> pixels.
#ifndef KINEGRAPH_CORE_GEOMETRY_CAMERA_H_
#define KINEGRAPH_CORE_GEOMETRY_CAMERA_H_

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/lens.h"
#include "core/geometry/projection.h"

namespace kinegraph {

using Matrix34d = Eigen::Matrix<double, 3, 4>;
using Matrix23d = Eigen::Matrix<double, 2, 3>;

// One camera as a calibration file describes it.
struct CameraParameters {
  std::string name;
  int width_px = 0;  // 0: unknown
  int height_px = 0;
  Eigen::Matrix3d K = Eigen::Matrix3d::Identity();  // pixels
  std::shared_ptr<const Lens> lens;                 // null: ideal pinhole
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();  // cam_from_world
  Eigen::Vector3d t = Eigen::Vector3d::Zero();      // cam_from_world, metres
};

// Immutable, so it may be shared between threads.
class Camera {
 public:
  // Throws OptionError when a focal length is not positive, K is not upper
  // triangular with K(2,2) = 1 (within 1e-6; K(1,0) relative to the focal
  // length), R R' deviates from the identity by more than 1e-3 (smaller
  // deviations, from rounding in files, are removed), R is a reflection, the
  // size is negative, or a number is not finite.
  explicit Camera(CameraParameters parameters);

  const std::string& name() const { return parameters_.name; }
  int width_px() const { return parameters_.width_px; }
  int height_px() const { return parameters_.height_px; }
  const Eigen::Matrix3d& K() const { return parameters_.K; }
  const Eigen::Matrix3d& R() const { return parameters_.R; }
  const Eigen::Vector3d& t() const { return parameters_.t; }
  const std::shared_ptr<const Lens>& lens() const { return parameters_.lens; }
  const CameraParameters& parameters() const { return parameters_; }
  // The camera as plain numbers, for code that works on packs of points.
  const CameraModel& model() const { return model_; }
  // P = K [R | t]: world [m] to ideal (undistorted) pixels, homogeneous.
  const Matrix34d& P() const { return P_; }
  // Position of the camera in the world [m].
  const Eigen::Vector3d& centre() const { return centre_; }
  // Mean of the two focal lengths [px].
  double focal_px() const { return 0.5 * (K()(0, 0) + K()(1, 1)); }

  // Depth along the optical axis [m]; not positive behind the camera.
  double Depth(const Eigen::Vector3d& point_in_world) const {
    return parameters_.R.row(2).dot(point_in_world) + parameters_.t.z();
  }

  // Raw pixel of a world point; nullopt when the point is not in front of the
  // camera or is outside the region in which the lens model is one-to-one.
  // `jacobian`, if not null, receives d pixel / d point (2x3, px/m).
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& point_in_world,
                                         Matrix23d* jacobian = nullptr) const;

  // Ideal pixel of a raw pixel: where a pinhole camera with the same K would
  // image the same ray. nullopt where the lens model cannot be inverted.
  std::optional<Eigen::Vector2d> Undistort(const Eigen::Vector2d& raw_px) const;

  // Unit direction in the world of the ray through an ideal pixel; the ray
  // starts at centre() (Chu et al. 2021, Eq. 3).
  Eigen::Vector3d RayDirection(const Eigen::Vector2d& ideal_px) const {
    return (KR_inverse_ * Eigen::Vector3d(ideal_px.x(), ideal_px.y(), 1.0))
        .normalized();
  }

 private:
  CameraParameters parameters_;
  CameraModel model_;
  Matrix34d P_;
  Eigen::Vector3d centre_;
  Eigen::Matrix3d K_inverse_;
  Eigen::Matrix3d KR_inverse_;
};

// Distance [m] of a point from the line through the camera's centre and the
// ideal pixel (RayDirection, extended behind the camera).
double DistanceToRay(const Camera& camera, const Eigen::Vector2d& ideal_px,
                     const Eigen::Vector3d& point_m);

// The cameras of a scene, in view order.
using CameraRig = std::vector<Camera>;

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_GEOMETRY_CAMERA_H_
