#include "core/geometry/camera.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>
#include <string>
#include <utility>

#include "core/base/error.h"

namespace kinegraph {
namespace {

// Throws OptionError if the camera cannot be used.
void CheckParameters(const CameraParameters& p) {
  if (!p.K.allFinite()) throw OptionError("K", "not all numbers are finite");
  if (!p.R.allFinite()) throw OptionError("R", "not all numbers are finite");
  if (!p.t.allFinite()) throw OptionError("t", "not all numbers are finite");
  if (p.width_px < 0 || p.height_px < 0) {
    throw OptionError("image_size", "found " + std::to_string(p.width_px) +
                                        " x " + std::to_string(p.height_px) +
                                        " px, expected no negative size");
  }
  constexpr double kRounding = 1e-6;  // for files that print six digits
  if (!(p.K(0, 0) > 0.0) || !(p.K(1, 1) > 0.0)) {
    throw OptionError("K", "singular or mirrored: focal lengths must be > 0");
  }
  const double scale = kRounding * p.K(0, 0);
  const bool triangular = std::abs(p.K(1, 0)) <= scale &&
                          std::abs(p.K(2, 0)) <= kRounding &&
                          std::abs(p.K(2, 1)) <= kRounding &&
                          std::abs(p.K(2, 2) - 1.0) <= kRounding;
  if (!triangular) {
    throw OptionError("K", "expected [fx s cx; 0 fy cy; 0 0 1]");
  }
  const Eigen::Matrix3d gram = p.R * p.R.transpose();
  const double deviation =
      (gram - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  constexpr double kRotationTolerance = 1e-3;  // hand-rounded files
  if (!(deviation <= kRotationTolerance) || p.R.determinant() <= 0.0) {
    throw OptionError("R",
                      "not a rotation (R R^T differs from the identity by " +
                          std::to_string(deviation) + ", determinant " +
                          std::to_string(p.R.determinant()) + ")");
  }
}

// Nearest rotation. A matrix that is orthonormal to 1e-9 is returned unchanged,
// bit for bit.
Eigen::Matrix3d Orthonormal(const Eigen::Matrix3d& R) {
  const Eigen::Matrix3d gram = R * R.transpose();
  if ((gram - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-9) {
    return R;
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(
      R, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

CameraModel PlainModel(const CameraParameters& p) {
  CameraModel model;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      model.R[row][column] = p.R(row, column);
    }
    model.t[row] = p.t(row);
  }
  model.fx = p.K(0, 0);
  model.skew = p.K(0, 1);
  model.fy = p.K(1, 1);
  model.cx = p.K(0, 2);
  model.cy = p.K(1, 2);
  if (p.lens != nullptr) model.lens = p.lens->plain();
  return model;
}

}  // namespace

Camera::Camera(CameraParameters parameters)
    : parameters_(std::move(parameters)) {
  CheckParameters(parameters_);
  parameters_.R = Orthonormal(parameters_.R);
  model_ = PlainModel(parameters_);
  P_.leftCols<3>() = parameters_.K * parameters_.R;
  P_.col(3) = parameters_.K * parameters_.t;
  centre_ = -parameters_.R.transpose() * parameters_.t;
  K_inverse_ = parameters_.K.inverse();
  KR_inverse_ = parameters_.R.transpose() * K_inverse_;
}

std::optional<Eigen::Vector2d> Camera::Project(
    const Eigen::Vector3d& point_in_world, Matrix23d* jacobian) const {
  Eigen::Vector2d px;
  double by_rows[6];
  if (!kinegraph::Project(model_, point_in_world.data(), &px.x(), &px.y(),
                          jacobian == nullptr ? nullptr : by_rows)) {
    return std::nullopt;
  }
  if (jacobian != nullptr) {
    *jacobian =
        Eigen::Map<const Eigen::Matrix<double, 2, 3, Eigen::RowMajor>>(by_rows);
  }
  return px;
}

std::optional<Eigen::Vector2d> Camera::Undistort(
    const Eigen::Vector2d& raw_px) const {
  if (lens() == nullptr) return raw_px;
  const Eigen::Vector2d distorted =
      (K_inverse_ * Eigen::Vector3d(raw_px.x(), raw_px.y(), 1.0)).head<2>();
  const std::optional<Eigen::Vector2d> ideal = lens()->Undistort(distorted);
  if (!ideal.has_value()) return std::nullopt;
  return K().topLeftCorner<2, 2>() * *ideal + K().block<2, 1>(0, 2);
}

double DistanceToRay(const Camera& camera, const Eigen::Vector2d& ideal_px,
                     const Eigen::Vector3d& point_m) {
  return (point_m - camera.centre())
      .cross(camera.RayDirection(ideal_px))
      .norm();
}

}  // namespace kinegraph
