#include "core/data/stance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/constants.h"

namespace kinegraph {
namespace {

using Eigen::Vector3d;

constexpr double kRadiansPerDegree = kPi / 180.0;

// Upward directions within this angle count as equal: people who sit or bend
// lean by less.
constexpr double kAlike_deg = 50.0;

// Mean of the class's joints; nullopt if none is present.
std::optional<Vector3d> Centre(const Skeleton& skeleton, const Pose3d& pose,
                               JointClass wanted) {
  Vector3d sum = Vector3d::Zero();
  int count = 0;
  for (int j = 0; j < skeleton.joint_count(); ++j) {
    const Joint3d& joint = pose[j];
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
  // Height of the hands above the shoulders, relative to the length from the
  // ankles (else hips) to the shoulders, above which a person is ignored.
  constexpr double kAbove = 0.1;
  constexpr size_t kMost = 2000;  // bodies; more add no information
  // A body is straight if the cosine of the angle between trunk and legs is
  // greater; it is 0.6 for a person on a chair.
  constexpr double kStraight = 0.8;
  const auto high = Centre(skeleton_, person.joints, JointClass::kShoulder);
  const auto hips = Centre(skeleton_, person.joints, JointClass::kHip);
  const auto ankles = Centre(skeleton_, person.joints, JointClass::kAnkle);
  const auto low = ankles ? ankles : hips;
  if (!low || !high) return;
  const Vector3d body_m = *high - *low;
  const auto hands = Centre(skeleton_, person.joints, JointClass::kWrist);
  if (!body_m.allFinite() || !(body_m.norm() > 0.0) ||
      (hands && (*hands - *high).dot(body_m) > kAbove * body_m.squaredNorm())) {
    return;
  }
  if (seen_++ % stride_ != 0) return;
  Body body;
  body.up = body_m.normalized();
  if (hips && ankles) {
    const Vector3d trunk = (*high - *hips).stableNormalized();
    body.is_straight =
        trunk.dot((*hips - *ankles).stableNormalized()) > kStraight;
    // The mean of trunk and ankle-to-shoulder: a person who sits or bends has
    // either the trunk or the legs upright.
    if (!body.is_straight) body.up = (body.up + trunk).stableNormalized();
  }
  for (const Joint3d& joint : person.joints) {
    if (joint.present() && joint.position_m.allFinite()) {
      body.joints_m.push_back(joint.position_m);
    }
  }
  bodies_.push_back(std::move(body));
  if (bodies_.size() < kMost) return;
  for (size_t i = 1; 2 * i < bodies_.size(); ++i) {
    bodies_[i] = std::move(bodies_[2 * i]);
  }
  bodies_.resize((bodies_.size() + 1) / 2);
  stride_ *= 2;
}

double Stance::Body::Low(const Vector3d& along) const {
  double low_m = std::numeric_limits<double>::infinity();
  for (const Vector3d& at : joints_m) low_m = std::min(low_m, along.dot(at));
  return low_m;
}

double Stance::Body::High(const Vector3d& along) const { return -Low(-along); }

// The group with the densest centre first; each body is in at most one.
std::vector<Stance::Group> Stance::Groups() const {
  constexpr double kLeastShare = 0.05;
  const double alike = std::cos(kAlike_deg * kRadiansPerDegree);
  const double near = std::cos(30.0 * kRadiansPerDegree);
  std::vector<const Body*> left;
  for (const Body& body : bodies_) left.push_back(&body);
  std::vector<Group> groups;
  while (!left.empty()) {
    // Centred on the body to which most others are close, among a sample.
    constexpr size_t kTried = 50;
    Vector3d middle = Vector3d::Zero();
    size_t most = 0;
    for (size_t i = 0; i < std::min(kTried, left.size()); ++i) {
      const Vector3d& at =
          left[i * left.size() / std::min(kTried, left.size())]->up;
      Vector3d sum = Vector3d::Zero();
      size_t count = 0;
      for (const Body* body : left) {
        if (body->up.dot(at) < near) continue;
        sum += body->up;
        ++count;
      }
      if (count <= most) continue;
      most = count;
      middle = sum.normalized();
    }
    Group group;
    std::vector<const Body*> others;
    double count = 0.0;
    for (const Body* body : left) {
      if (body->up.dot(middle) < alike) {
        others.push_back(body);
        continue;
      }
      group.up += body->up;
      group.straight += body->is_straight ? 1.0 : 0.0;
      ++count;
    }
    // If no body is near the mean, the loop would repeat forever.
    if (others.size() == left.size()) break;
    left = std::move(others);
    group.share = count / static_cast<double>(bodies_.size());
    group.straight /= count;
    group.up.normalize();
    if (group.share < kLeastShare) break;
    groups.push_back(group);
  }
  return groups;
}

// From the 5 % to the 95 % quantile.
double Stance::FloorSpread(const Vector3d& up) const {
  std::vector<double> lows_m;
  for (const Body& body : bodies_) lows_m.push_back(body.Low(up));
  return Quantile(lows_m, 0.95) - Quantile(lows_m, 0.05);
}

// People who walk or lie share a floor: the coordinate of their lowest joints
// is constant along the vertical and along no other direction. For a person who
// does not move, it is constant along every direction.
std::optional<Vector3d> Stance::ByFloor(
    const std::vector<Group>& groups,
    const std::vector<Vector3d>& others) const {
  constexpr double kFloor_m = 0.7;  // from lying on the floor to lying on a bed
  // The next best spread must be greater by this factor and this difference.
  constexpr double kTimes = 2.5;
  constexpr double kApart_m = 0.4;
  const double alike = std::cos(kAlike_deg * kRadiansPerDegree);
  std::vector<Vector3d> candidates;
  for (const Group& group : groups) candidates.push_back(group.up);
  for (const Vector3d& other : others) {
    if (std::none_of(
            candidates.begin(), candidates.end(),
            [&](const Vector3d& one) { return one.dot(other) > alike; })) {
      candidates.push_back(other);
    }
  }
  double least_m = std::numeric_limits<double>::infinity();
  double next_m = least_m;
  Vector3d best = Vector3d::Zero();
  for (const Vector3d& up : candidates) {
    const double spread_m = FloorSpread(up);
    if (spread_m < least_m) {
      next_m = least_m;
      least_m = spread_m;
      best = up;
    } else {
      next_m = std::min(next_m, spread_m);
    }
  }
  if (candidates.size() < 2 || least_m > kFloor_m ||
      next_m < std::max(kTimes * least_m, least_m + kApart_m)) {
    return std::nullopt;
  }
  return best;
}

// Assumes a floor at height 0.
bool Stance::MayLie(const Vector3d& up) const {
  std::vector<double> lows_m;
  std::vector<double> highs_m;
  std::vector<double> middles_m;
  for (const Body& body : bodies_) {
    lows_m.push_back(body.Low(up));
    highs_m.push_back(body.High(up));
    middles_m.push_back(0.5 * (lows_m.back() + highs_m.back()));
  }
  const double low_m = Quantile(lows_m, 0.5);
  const double high_m = Quantile(highs_m, 0.5);
  // Upper bounds of the thickness of a lying body, and of the height of its
  // upper side on a bed.
  constexpr double kThick_m = 0.7;
  constexpr double kHigh_m = 1.3;
  constexpr double kError_m = 0.15;  // joints may be this far below the floor
  // A greater spread of the bodies' middle heights shows that people move up
  // and down.
  constexpr double kSpread_m = 0.3;
  return high_m - low_m < kThick_m && low_m > -kError_m && high_m < kHigh_m &&
         Quantile(middles_m, 0.95) - Quantile(middles_m, 0.05) < kSpread_m;
}

std::optional<Vector3d> Stance::Up(const UpEvidence& known) const {
  constexpr double kNearlyAll = 0.8;  // of the bodies
  constexpr double kSits_deg = 40.0;
  const double alike = std::cos(kAlike_deg * kRadiansPerDegree);
  std::optional<Vector3d> cameras;
  if (known.of_cameras.norm() > 0.0) {
    cameras = NearestAxis(known.of_cameras, kSits_deg)
                  .value_or(known.of_cameras.normalized());
  }
  if (bodies_.empty()) return known.stated ? known.stated : cameras;
  const std::vector<Group> groups = Groups();
  std::vector<Vector3d> others;
  if (known.stated) others.push_back(*known.stated);
  if (cameras) others.push_back(*cameras);
  if (auto up = ByFloor(groups, others)) return up;
  const bool is_one = !groups.empty() && groups.front().share >= kNearlyAll;
  if (!is_one) return known.stated ? known.stated : cameras;
  const Group& all = groups.front();
  // A lying person is not head down and does not sit.
  const auto may_lie = [&](const Vector3d& up) {
    return all.straight > 0.5 && std::abs(all.up.dot(up)) < alike && MayLie(up);
  };
  if (known.stated) {
    const bool stands_across =
        all.up.dot(*known.stated) < alike && !may_lie(*known.stated);
    if (!stands_across) return known.stated;
  }
  if (cameras && all.up.dot(*cameras) < alike) return std::nullopt;
  if (!cameras && may_lie(Vector3d::UnitZ())) return std::nullopt;
  // A sitting person may lean by more than the world's axes are tilted.
  return all.straight > 0.5 ? std::optional(all.up)
                            : NearestAxis(all.up, kSits_deg);
}

std::optional<Vector3d> Stance::UpUnlike(const Vector3d& up,
                                         const UpEvidence& known) const {
  const auto own = bodies_.empty() ? std::nullopt : Up(known);
  if (!own || own->dot(up) > std::cos(kAlike_deg * kRadiansPerDegree)) {
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
