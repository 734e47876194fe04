#include "core/data/stance.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kinegraph {
namespace {

using Eigen::Vector3d;

constexpr double kRadiansPerDegree = 3.14159265358979323846 / 180.0;

// Mean of the class's joints; nullopt when none is there.
std::optional<Vector3d> Centre(const Skeleton& skeleton, const Pose3d& pose,
                               JointClass wanted) {
  Vector3d sum = Vector3d::Zero();
  int count = 0;
  for (int j = 0; j < skeleton.joint_count(); ++j) {
    const Joint3d& joint = pose[static_cast<size_t>(j)];
    if (skeleton.joint_class(j) != wanted || !joint.present()) continue;
    sum += joint.position_m;
    ++count;
  }
  if (count == 0) return std::nullopt;
  return sum / count;
}

double Quantile(std::vector<double> values, double share) {
  const auto at = values.begin() +
                  std::lround(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace

Vector3d UpOfCameras(const CameraRig& cameras) {
  Vector3d sum = Vector3d::Zero();
  for (const Camera& camera : cameras) sum -= camera.R().row(1).transpose();
  return sum;
}

std::optional<Vector3d> NearestAxis(const Vector3d& direction,
                                    double within_deg) {
  const Vector3d unit = direction.normalized();
  Eigen::Index axis = 0;
  const double cosine = unit.cwiseAbs().maxCoeff(&axis);
  if (!(cosine >= std::cos(within_deg * kRadiansPerDegree)))
    return std::nullopt;
  return Vector3d(std::copysign(1.0, unit[axis]) * Vector3d::Unit(axis));
}

void Stance::See(const PersonPose& person) {
  const auto low = Centre(skeleton_, person.joints, JointClass::kAnkle);
  const auto high = Centre(skeleton_, person.joints, JointClass::kShoulder);
  if (!low || !high) return;
  const Vector3d body_m = *high - *low;
  if (!body_m.allFinite()) return;
  body_sum_m_ += body_m;
  const auto hands = Centre(skeleton_, person.joints, JointClass::kWrist);
  constexpr double kAbove = 0.1;  // of the way from ankles to shoulders
  if (!(body_m.norm() > 0.0) ||
      (hands && (*hands - *high).dot(body_m) > kAbove * body_m.squaredNorm())) {
    return;
  }
  direction_sum_ += body_m.normalized();
  constexpr double kMost = std::numeric_limits<double>::max();
  Extent extent = {{kMost, kMost, kMost}, {-kMost, -kMost, -kMost}};
  for (const Joint3d& joint : person.joints) {
    if (!joint.present()) continue;
    for (size_t k = 0; k < 3; ++k) {
      const double at_m = joint.position_m[static_cast<Eigen::Index>(k)];
      extent.low_m[k] = std::min(extent.low_m[k], at_m);
      extent.high_m[k] = std::max(extent.high_m[k], at_m);
    }
  }
  extents_.push_back(extent);
}

std::optional<Vector3d> Stance::Up() const {
  constexpr double kAgreement = 0.8;  // as of directions spread by 37 degrees
  const double sum = direction_sum_.norm();
  if (extents_.empty() ||
      sum < kAgreement * static_cast<double>(extents_.size())) {
    return std::nullopt;
  }
  return Vector3d(direction_sum_ / sum);
}

bool Stance::MayLie(const Vector3d& up) const {
  Eigen::Index axis = 0;
  up.cwiseAbs().maxCoeff(&axis);
  const auto k = static_cast<size_t>(axis);
  std::vector<double> lows_m;
  std::vector<double> highs_m;
  std::vector<double> middles_m;
  for (const Extent& extent : extents_) {
    const bool is_positive = up[axis] > 0.0;
    lows_m.push_back(is_positive ? extent.low_m[k] : -extent.high_m[k]);
    highs_m.push_back(is_positive ? extent.high_m[k] : -extent.low_m[k]);
    middles_m.push_back(0.5 * (lows_m.back() + highs_m.back()));
  }
  const double low_m = Quantile(lows_m, 0.5);
  const double high_m = Quantile(highs_m, 0.5);
  // A body is no thicker, a bed no higher; beds of a ward are alike.
  constexpr double kThick_m = 0.7;
  constexpr double kHigh_m = 1.3;
  constexpr double kError_m = 0.15;
  constexpr double kSpread_m = 0.3;
  return high_m - low_m < kThick_m && low_m > -kError_m && high_m < kHigh_m &&
         Quantile(middles_m, 0.95) - Quantile(middles_m, 0.05) < kSpread_m;
}

std::optional<Vector3d> Stance::UpUnlike(const Vector3d& up,
                                         const CameraRig& cameras) const {
  const double alike = std::cos(50.0 * kRadiansPerDegree);
  const auto own = Up();
  if (!own || own->dot(up) > alike) return std::nullopt;
  const Vector3d of_cameras = UpOfCameras(cameras);
  if (of_cameras.norm() > 0.0) {
    if (own->dot(of_cameras.normalized()) < alike) return std::nullopt;
  } else if (own->dot(up) > -alike && MayLie(up)) {  // nobody lies head down
    return std::nullopt;
  }
  return own;
}

Stance StanceOf(const Skeleton& skeleton,
                const std::vector<TrackFrame>& frames) {
  Stance stance(skeleton);
  for (const TrackFrame& frame : frames) {
    for (const PersonPose& person : frame.people) stance.See(person);
  }
  return stance;
}

}  // namespace kinegraph
