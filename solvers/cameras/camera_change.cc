#include "solvers/cameras/camera_change.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "core/geometry/lens.h"

namespace kinegraph {
namespace {

// d exp(vector) y / d vector = -[exp(vector) y]x J(vector): the left Jacobian
// of rotations (Barfoot, State Estimation for Robotics, section 7.1.5).
Eigen::Matrix3d LeftJacobian(const Eigen::Vector3d& vector) {
  const double angle = vector.norm();
  const Eigen::Matrix3d cross = CrossMatrix(vector);
  // Below this angle the next terms of the series are below double precision.
  constexpr double kSmall = 1e-5;
  if (angle < kSmall) {
    return Eigen::Matrix3d::Identity() + 0.5 * cross + cross * cross / 6.0;
  }
  const double square = angle * angle;
  return Eigen::Matrix3d::Identity() +
         (1.0 - std::cos(angle)) / square * cross +
         (angle - std::sin(angle)) / (square * angle) * cross * cross;
}

// FirstRadialFactor for k2: r^4, or a^5 / r for a fisheye lens, with r the
// distance from the optical axis in normalised coordinates and a = atan(r).
double SecondRadialFactor(const Lens* lens, const Eigen::Vector2d& ideal,
                          Eigen::Matrix2d* jacobian) {
  const double first = FirstRadialFactor(lens, ideal, jacobian);
  // The second factor is the first times r^2, or a^2.
  const double r2 = ideal.squaredNorm();
  double times = r2;
  double slope = 2.0;  // (d times / d r) / r
  constexpr double kSmall = 1e-16;
  if (lens != nullptr && lens->plain().kind == LensKind::kFisheye &&
      r2 > kSmall) {
    const double r = std::sqrt(r2);
    const double angle = std::atan(r);
    times = angle * angle;
    slope = 2.0 * angle / (r * (1.0 + r2));
  }
  if (jacobian != nullptr) {
    *jacobian = times * *jacobian + first * slope * ideal * ideal.transpose();
  }
  return first * times;
}

// The lens after the change; null is a pinhole camera.
std::shared_ptr<const Lens> ChangedLens(const std::shared_ptr<const Lens>& lens,
                                        const CameraChange& change) {
  if (change[kLensAt] == 0.0 && change[kLensK2At] == 0.0) return lens;
  const auto first = WithRadial(lens, change[kLensAt]);
  std::vector<double> terms(5, 0.0);
  if (first != nullptr) terms = first->parameters();
  terms[1] += change[kLensK2At];
  return MakeLens(first == nullptr ? "opencv5" : first->model(), terms);
}

}  // namespace

Eigen::Matrix3d CrossMatrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d matrix;
  matrix << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return matrix;
}

Eigen::Matrix3d ExpRotation(const Eigen::Vector3d& vector) {
  const double angle = vector.stableNorm();
  if (!(angle > 0.0)) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, vector / angle).toRotationMatrix();
}

std::optional<Eigen::Vector2d> ProjectChanged(
    const Camera& camera, const CameraChange& change,
    const Eigen::Vector3d& point_m, Matrix23d* by_point,
    Eigen::Matrix<double, 2, kChangeSize>* by_change) {
  const Eigen::Vector3d vector = change.segment<3>(kRotationAt);
  Eigen::Matrix3d R = camera.R();
  if (!vector.isZero(0.0)) R = ExpRotation(vector) * R;
  const Eigen::Vector3d in_camera =
      R * (point_m - camera.centre() - change.segment<3>(kCentreAt));
  if (!(in_camera.z() > 0.0)) return std::nullopt;
  const double inverse_z = 1.0 / in_camera.z();
  const Eigen::Vector2d ideal = in_camera.head<2>() * inverse_z;
  const bool wants_jacobian = by_point != nullptr || by_change != nullptr;
  Eigen::Vector2d distorted = ideal;
  Eigen::Matrix2d d_lens = Eigen::Matrix2d::Identity();
  if (camera.lens() != nullptr) {
    if (!camera.lens()->InDomain(ideal)) return std::nullopt;
    distorted =
        camera.lens()->Distort(ideal, wants_jacobian ? &d_lens : nullptr);
  }
  if (change[kLensAt] != 0.0 || change[kLensK2At] != 0.0) {
    Eigen::Matrix2d d_first;
    Eigen::Matrix2d d_second;
    const Lens* lens = camera.lens().get();
    const double added =
        change[kLensAt] * FirstRadialFactor(lens, ideal, &d_first) +
        change[kLensK2At] * SecondRadialFactor(lens, ideal, &d_second);
    const Eigen::Matrix2d d_added =
        change[kLensAt] * d_first + change[kLensK2At] * d_second;
    // Beyond the radius r at which r (1 + added) ceases to grow, a point has no
    // image.
    const double along = ideal.dot(d_added * ideal);
    if (!(ideal.squaredNorm() + along >= 0.0)) return std::nullopt;
    distorted += added * ideal;
    d_lens += d_added;
  }
  const Eigen::Matrix2d k =
      std::exp(change[kFocalAt]) * camera.K().topLeftCorner<2, 2>();
  const Eigen::Vector2d magnified = k * distorted;
  const Eigen::Vector2d px =
      magnified + camera.K().block<2, 1>(0, 2) + change.segment<2>(kShiftAt);
  if (!px.allFinite()) return std::nullopt;
  if (wants_jacobian) {
    Matrix23d d_ideal;  // with respect to the point in the camera frame
    d_ideal << inverse_z, 0.0, -ideal.x() * inverse_z, 0.0, inverse_z,
        -ideal.y() * inverse_z;
    const Matrix23d by_camera_point = k * d_lens * d_ideal;
    const Matrix23d by_world = by_camera_point * R;
    if (by_point != nullptr) *by_point = by_world;
    if (by_change != nullptr) {
      by_change->setZero();
      by_change->middleCols<3>(kRotationAt) =
          -by_camera_point * CrossMatrix(in_camera) * LeftJacobian(vector);
      by_change->middleCols<3>(kCentreAt) = -by_world;
      by_change->middleCols<2>(kShiftAt).setIdentity();
      by_change->col(kFocalAt) = magnified;
      by_change->col(kLensAt) =
          k * (FirstRadialFactor(camera.lens().get(), ideal, nullptr) * ideal);
      by_change->col(kLensK2At) =
          k * (SecondRadialFactor(camera.lens().get(), ideal, nullptr) * ideal);
    }
  }
  return px;
}

Camera ChangedCamera(const Camera& camera, const CameraChange& change) {
  return Edited(camera, [&](CameraParameters* changed) {
    changed->K.topLeftCorner<2, 2>() *= std::exp(change[kFocalAt]);
    changed->K.block<2, 1>(0, 2) += change.segment<2>(kShiftAt);
    changed->R = ExpRotation(change.segment<3>(kRotationAt)) * camera.R();
    changed->lens = ChangedLens(camera.lens(), change);
    changed->t =
        -(changed->R * (camera.centre() + change.segment<3>(kCentreAt)));
  });
}

CameraRig RefinedCameras(const CameraRig& cameras,
                         const std::vector<CameraChange>& changes) {
  CameraRig rig;
  for (size_t v = 0; v < cameras.size(); ++v) {
    // Unchanged cameras remain bitwise equal.
    rig.push_back(changes[v].isZero(0.0)
                      ? cameras[v]
                      : ChangedCamera(cameras[v], changes[v]));
  }
  return rig;
}

CameraRig Rescaled(const CameraRig& cameras, double factor) {
  if (factor == 1.0) return cameras;
  return Edited(cameras,
                [&](CameraParameters* camera) { camera->t *= factor; });
}

void RescaleCentres(const std::vector<std::vector<int>>& places, double factor,
                    Eigen::MatrixXd* covariance) {
  Eigen::Index at = 0;
  for (const std::vector<int>& list : places) {
    for (size_t i = 0; i < list.size(); ++i, ++at) {
      if (list[i] < kCentreAt || list[i] >= kCentreAt + 3) continue;
      covariance->row(at) *= factor;
      covariance->col(at) *= factor;
    }
  }
}

namespace {

// The blocks of a change, in the order of FreeParameters::Places.
struct ChangeBlock {
  bool FreeParameters::*is_free;
  int begin;
  int size;
};
constexpr ChangeBlock kBlocks[] = {{&FreeParameters::rotation, kRotationAt, 3},
                                   {&FreeParameters::centre, kCentreAt, 3},
                                   {&FreeParameters::shift, kShiftAt, 2},
                                   {&FreeParameters::focal, kFocalAt, 1},
                                   {&FreeParameters::offset, kOffsetAt, 1},
                                   {&FreeParameters::drift, kDriftAt, 1},
                                   {&FreeParameters::lens, kLensAt, 1},
                                   {&FreeParameters::lens_k2, kLensK2At, 1}};

}  // namespace

FreeParameters FreeParameters::At(const std::vector<int>& places) {
  FreeParameters free;
  for (const auto& [is_free, begin, size] : kBlocks) {
    free.*is_free = std::count(places.begin(), places.end(), begin) > 0;
  }
  return free;
}

std::vector<int> FreeParameters::Places() const {
  std::vector<int> places;
  for (const auto& [is_free, begin, size] : kBlocks) {
    for (int i = 0; this->*is_free && i < size; ++i)
      places.push_back(begin + i);
  }
  return places;
}

FreeParameters ClockParametersOf(double span_s) {
  constexpr double kDriftSpanS = 20.0;
  FreeParameters clock;
  clock.offset = true;
  clock.drift = span_s > kDriftSpanS;
  return clock;
}

}  // namespace kinegraph
