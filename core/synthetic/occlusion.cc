#include "core/synthetic/occlusion.h"

#include <algorithm>
#include <utility>

namespace kinegraph {

using Eigen::Vector3d;

// Closest points by clamping, as in Ericson, Real-Time Collision Detection,
// section 5.1.9.
double SquaredSegmentDistance(const Vector3d& p0, const Vector3d& p1,
                              const Vector3d& q0, const Vector3d& q1) {
  constexpr double kTiny = 1e-12;
  const Vector3d d1 = p1 - p0;
  const Vector3d d2 = q1 - q0;
  const Vector3d r = p0 - q0;
  const double a = d1.squaredNorm();
  const double e = d2.squaredNorm();
  const double f = d2.dot(r);
  double s = 0.0;
  double t = 0.0;
  if (a <= kTiny) {
    t = e <= kTiny ? 0.0 : std::clamp(f / e, 0.0, 1.0);
  } else {
    const double c = d1.dot(r);
    if (e <= kTiny) {
      s = std::clamp(-c / a, 0.0, 1.0);
    } else {
      const double b = d1.dot(d2);
      const double denominator = a * e - b * b;
      if (denominator > kTiny) {
        s = std::clamp((b * f - c * e) / denominator, 0.0, 1.0);
      }
      t = (b * s + f) / e;
      if (t < 0.0 || t > 1.0) {
        t = std::clamp(t, 0.0, 1.0);
        s = std::clamp((b * t - c) / a, 0.0, 1.0);
      }
    }
  }
  return (r + s * d1 - t * d2).squaredNorm();
}

Obstacle::Obstacle(const std::vector<Capsule>& capsules, const BodyPose& pose) {
  for (const Capsule& capsule : capsules) {
    capsules_.push_back({PositionOf(capsule.a, pose),
                         PositionOf(capsule.b, pose), capsule.radius_m});
  }
  centre_ = pose[static_cast<size_t>(Segment::kPelvis)].origin_m;
  BoundAll();
}

Obstacle::Obstacle(std::vector<PlacedCapsule> capsules, const Vector3d& centre)
    : capsules_(std::move(capsules)), centre_(centre) {
  BoundAll();
}

void Obstacle::BoundAll() {
  for (const PlacedCapsule& part : capsules_) {
    const double reach =
        std::max((part.a - centre_).norm(), (part.b - centre_).norm());
    radius_m_ = std::max(radius_m_, reach + part.radius_m);
  }
}

bool Obstacle::Hides(const Vector3d& eye, const Vector3d& point) const {
  if (SquaredSegmentDistance(eye, point, centre_, centre_) >
      radius_m_ * radius_m_) {
    return false;
  }
  return std::any_of(
      capsules_.begin(), capsules_.end(), [&](const PlacedCapsule& part) {
        return SquaredSegmentDistance(eye, point, part.a, part.b) <
               part.radius_m * part.radius_m;
      });
}

}  // namespace kinegraph
