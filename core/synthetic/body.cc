#include "core/synthetic/body.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/skeleton/anthropometry.h"

namespace kinegraph {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d RotationAbout(const Vector3d& axis, double angle_rad) {
  return Eigen::AngleAxisd(angle_rad, axis).toRotationMatrix();
}
Matrix3d RotX(double a) { return RotationAbout(Vector3d::UnitX(), a); }
Matrix3d RotY(double a) { return RotationAbout(Vector3d::UnitY(), a); }
Matrix3d RotZ(double a) { return RotationAbout(Vector3d::UnitZ(), a); }

// Distance from hip to ankle for a requested distance: equal well below the
// leg's length, and smoothly limited near it, so that the knee never
// straightens abruptly.
double ReachableDistance(double wanted_m, double leg_m) {
  const double limit = 0.999 * leg_m;
  const double softness = 0.035 * leg_m;
  const double bend_from = limit - softness;
  if (wanted_m <= bend_from) return wanted_m;
  return limit - softness * std::exp(-(wanted_m - bend_from) / softness);
}

// Rotation whose z axis points from `low` to `high` and whose x axis lies in
// the plane spanned by z and `forward`.
Matrix3d AlongBone(const Vector3d& low, const Vector3d& high,
                   const Vector3d& forward) {
  const Vector3d z = (high - low).normalized();
  const Vector3d y = z.cross(forward).normalized();
  Matrix3d R;
  R << y.cross(z), y, z;
  return R;
}

// Two bones from hip to ankle; the knee bends towards `forward`.
void PlaceLeg(const BodyShape& shape, int side, const Vector3d& forward,
              const FootPosture& foot, BodyPose* pose) {
  const SegmentPose& pelvis = (*pose)[static_cast<size_t>(Segment::kPelvis)];
  const Vector3d hip =
      pelvis.origin_m +
      pelvis.R * Vector3d(0.0, SignOf(side) * shape.hip_half_width, 0.0);
  const Vector3d to_ankle = foot.ankle_m - hip;
  const double wanted = to_ankle.norm();
  const Vector3d axis = to_ankle / wanted;
  // A knee bends to about 150 degrees, which bounds the distance from below.
  const double distance =
      std::max(ReachableDistance(wanted, shape.leg()), 0.27 * shape.leg());
  const double along = (distance * distance + shape.thigh * shape.thigh -
                        shape.shank * shape.shank) /
                       (2.0 * distance);
  const double aside =
      std::sqrt(std::max(0.0, shape.thigh * shape.thigh - along * along));
  const Vector3d bend = (forward - axis * axis.dot(forward)).normalized();
  const Vector3d knee = hip + along * axis + aside * bend;
  const Vector3d ankle = hip + distance * axis;

  auto set = [&](Segment part, const Vector3d& origin, const Matrix3d& R) {
    (*pose)[static_cast<size_t>(Sided(part, side))] = {R, origin};
  };
  set(Segment::kThigh, hip, AlongBone(knee, hip, forward));
  set(Segment::kShank, knee, AlongBone(ankle, knee, forward));
  set(Segment::kFoot, ankle, RotZ(foot.yaw) * RotY(foot.pitch));
}

void PlaceArm(const BodyShape& shape, int side, const ArmPosture& arm,
              BodyPose* pose) {
  const SegmentPose& thorax = (*pose)[static_cast<size_t>(Segment::kThorax)];
  const double sign = SignOf(side);
  const Vector3d shoulder =
      thorax.origin_m + thorax.R * Vector3d(0.0,
                                            sign * shape.shoulder_half_width,
                                            shape.shoulder_height);
  const Matrix3d R_upper = thorax.R * RotY(-arm.flexion) *
                           RotX(sign * arm.abduction) *
                           RotZ(-sign * arm.rotation);
  const Vector3d elbow =
      shoulder + R_upper * Vector3d(0.0, 0.0, -shape.upper_arm);
  (*pose)[static_cast<size_t>(Sided(Segment::kUpperArm, side))] = {R_upper,
                                                                   shoulder};
  (*pose)[static_cast<size_t>(Sided(Segment::kForearm, side))] = {
      R_upper * RotY(-arm.elbow), elbow};
}

using NamedPoints = std::map<std::string, BodyPoint>;

void AddCentralPoints(const BodyShape& shape, NamedPoints* points) {
  const double h = shape.stature;
  auto& p = *points;
  p["mid_hip"] = {Segment::kPelvis, Vector3d::Zero()};
  p["neck"] = {Segment::kThorax, {0.0, 0.0, shape.neck_height}};
  p["head_bottom"] = {Segment::kHead, {0.006 * h, 0.0, 0.02 * h}};
  p["head_top"] = {Segment::kHead, {0.012 * h, 0.0, shape.head_height}};
  p["nose"] = {Segment::kHead, {0.068 * h, 0.0, 0.076 * h}};
}

void AddSidedPoints(const BodyShape& shape, int side, NamedPoints* points) {
  const double h = shape.stature;
  const double y = SignOf(side);
  const double foot = shape.foot_length;
  const double sole = -shape.ankle_height;
  const std::string prefix = side == kLeft ? "l_" : "r_";
  auto add = [&](const std::string& name, Segment segment,
                 const Vector3d& offset) {
    (*points)[prefix + name] = {segment, offset};
  };
  auto sided = [&](Segment part) { return Sided(part, side); };
  add("eye", Segment::kHead, {0.056 * h, y * 0.018 * h, 0.095 * h});
  add("eye_inner", Segment::kHead, {0.057 * h, y * 0.012 * h, 0.095 * h});
  add("eye_outer", Segment::kHead, {0.052 * h, y * 0.025 * h, 0.095 * h});
  add("mouth", Segment::kHead, {0.058 * h, y * 0.014 * h, 0.058 * h});
  add("ear", Segment::kHead, {0.008 * h, y * 0.043 * h, 0.090 * h});
  add("shoulder", sided(Segment::kUpperArm), Vector3d::Zero());
  add("elbow", sided(Segment::kForearm), Vector3d::Zero());
  add("wrist", sided(Segment::kForearm), {0.0, 0.0, -shape.forearm});
  // The roots of the fingers, with the thumb in front.
  const double hand = -shape.forearm - 0.045 * h;
  add("pinky", sided(Segment::kForearm), {-0.02 * h, 0.0, hand});
  add("index", sided(Segment::kForearm), {0.012 * h, 0.0, hand - 0.01 * h});
  add("thumb", sided(Segment::kForearm), {0.028 * h, 0.0, hand + 0.015 * h});
  add("hip", Segment::kPelvis, {0.0, y * shape.hip_half_width, 0.0});
  add("knee", sided(Segment::kShank), Vector3d::Zero());
  add("ankle", sided(Segment::kFoot), Vector3d::Zero());
  add("heel", sided(Segment::kFoot), {-0.22 * foot, 0.0, 0.6 * sole});
  add("big_toe", sided(Segment::kFoot), {0.72 * foot, -y * 0.12 * foot, sole});
  add("foot_index", sided(Segment::kFoot),
      {0.72 * foot, -y * 0.05 * foot, sole});
  add("small_toe", sided(Segment::kFoot), {0.6 * foot, y * 0.2 * foot, sole});
}

// "face_12" with prefix "face_" is 12.
std::optional<int> NumberAfter(const std::string& prefix,
                               const std::string& name) {
  if (name.compare(0, prefix.size(), prefix) != 0) return std::nullopt;
  const std::string digits = name.substr(prefix.size());
  if (digits.size() > 3) return std::nullopt;
  return ParseNumber<uint16_t>(digits);  // without a sign
}

// Point of a whole-body skeleton: distributed over the front of the head or the
// five fingers of a hand (0 is its root, then four points per finger).
std::optional<BodyPoint> WholeBodyPoint(const BodyShape& shape,
                                        const std::string& name) {
  const double h = shape.stature;
  for (const auto& [prefix, side] :
       {std::pair{"face_", 0.0}, {"l_face_", 1.0}, {"r_face_", -1.0}}) {
    const auto face = NumberAfter(prefix, name);
    if (!face) continue;
    constexpr double kGoldenAngle = 2.399963229728653;
    const double radius = std::sqrt((*face % 68 + 0.5) / 68.0);
    const double angle = *face * kGoldenAngle;
    return BodyPoint{Segment::kHead,
                     {(0.064 - 0.03 * radius * radius) * h,
                      0.04 * h * radius * side * std::abs(std::cos(angle)),
                      (0.085 + 0.05 * radius * std::sin(angle)) * h}};
  }
  for (const int side : {kLeft, kRight}) {
    const auto hand = NumberAfter(side == kLeft ? "l_hand_" : "r_hand_", name);
    if (!hand) continue;
    const int point = *hand % 21;
    const int finger = (point + 3) / 4;  // 0: root, 1: thumb ... 5
    const int knuckle = point == 0 ? 0 : (point - 1) % 4 + 1;
    const double reach = point == 0 ? 0.0 : (0.03 + 0.015 * knuckle) * h;
    const double spread = point == 0 ? 0.0 : 0.25 * (finger - 3);
    return BodyPoint{Sided(Segment::kForearm, side),
                     {-reach * std::sin(spread), 0.0,
                      -shape.forearm - reach * std::cos(spread)}};
  }
  return std::nullopt;
}

}  // namespace

BodyShape MakeBodyShape(double stature_m, double leg_share) {
  const double h = stature_m;
  BodyShape shape;
  shape.stature = h;
  shape.thigh = kThighShare * leg_share * h;
  shape.shank = kShankShare * leg_share * h;
  shape.ankle_height = kAnkleHeightShare * h;
  shape.hip_half_width = 0.05 * h;
  shape.foot_length = kFootShare * h;
  shape.head_height = 0.165 * h;
  // The trunk is the stature minus the head and the legs.
  const double hips = shape.leg() + shape.ankle_height;
  shape.neck_height = h - shape.head_height - hips;
  shape.shoulder_height = shape.neck_height - 0.02 * h;
  shape.shoulder_half_width = 0.108 * h;
  shape.upper_arm = kUpperArmShare * h;
  shape.forearm = kForearmShare * h;
  return shape;
}

BodyPose PlaceBody(const BodyShape& shape, const Posture& posture) {
  BodyPose pose;
  auto at = [&](Segment segment) -> SegmentPose& {
    return pose[static_cast<size_t>(segment)];
  };
  const Matrix3d R_heading = RotZ(posture.heading);
  at(Segment::kPelvis) = {R_heading * RotY(posture.lean), posture.pelvis_m};
  at(Segment::kThorax) = {at(Segment::kPelvis).R * RotZ(posture.twist),
                          posture.pelvis_m};
  const SegmentPose& thorax = at(Segment::kThorax);
  at(Segment::kHead) = {
      thorax.R * RotZ(posture.head_yaw) * RotY(posture.head_pitch),
      thorax.origin_m + thorax.R * Vector3d(0.0, 0.0, shape.neck_height)};
  for (const int side : {kLeft, kRight}) {
    PlaceArm(shape, side, posture.arms[side], &pose);
    PlaceLeg(shape, side, R_heading.col(0), posture.feet[side], &pose);
  }
  return pose;
}

std::vector<BodyPoint> PointsOf(const BodyShape& shape,
                                const Skeleton& skeleton) {
  NamedPoints known;
  AddCentralPoints(shape, &known);
  for (const int side : {kLeft, kRight}) AddSidedPoints(shape, side, &known);
  std::vector<BodyPoint> points;
  for (const std::string& joint : skeleton.joints()) {
    const auto at = known.find(joint);
    if (at != known.end()) {
      points.push_back(at->second);
    } else if (const auto extra = WholeBodyPoint(shape, joint)) {
      points.push_back(*extra);
    } else {
      throw OptionError("skeleton", "a synthetic body has no joint '" +
                                        Printable(joint) + "'");
    }
  }
  return points;
}

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

Obstacle::Obstacle(std::vector<Capsule> capsules, const Vector3d& centre)
    : capsules_(std::move(capsules)), centre_(centre) {
  for (const Capsule& part : capsules_) {
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
      capsules_.begin(), capsules_.end(), [&](const Capsule& part) {
        return SquaredSegmentDistance(eye, point, part.a, part.b) <
               part.radius_m * part.radius_m;
      });
}

Obstacle ObstacleOf(const BodyShape& shape, const BodyPose& pose) {
  const double h = shape.stature;
  std::vector<Capsule> capsules;
  const auto add = [&](const BodyPoint& a, const BodyPoint& b, double radius) {
    capsules.push_back({PositionOf(a, pose), PositionOf(b, pose), radius});
  };
  add({Segment::kPelvis, Vector3d::Zero()},
      {Segment::kThorax, {0.0, 0.0, 0.8 * shape.neck_height}}, 0.085 * h);
  add({Segment::kHead, {0.0, 0.0, 0.06 * h}},
      {Segment::kHead, {0.01 * h, 0.0, 0.11 * h}}, 0.05 * h);
  for (const int side : {kLeft, kRight}) {
    const auto bone = [&](Segment part, double length, double radius) {
      const Segment segment = Sided(part, side);
      add({segment, Vector3d::Zero()}, {segment, {0.0, 0.0, -length}}, radius);
    };
    bone(Segment::kUpperArm, shape.upper_arm, 0.026 * h);
    bone(Segment::kForearm, shape.forearm, 0.022 * h);
    bone(Segment::kThigh, shape.thigh, 0.04 * h);
    bone(Segment::kShank, shape.shank, 0.03 * h);
  }
  return {std::move(capsules),
          pose[static_cast<size_t>(Segment::kPelvis)].origin_m};
}

}  // namespace kinegraph
