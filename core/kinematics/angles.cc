#include "core/kinematics/angles.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/constants.h"

namespace kinegraph {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Sigmas that contain 95 % of a Gaussian in one and in two dimensions.
constexpr double kSigmas = 1.959964;
constexpr double kDiscSigmas = 2.447747;
// A shorter vector has no direction [m].
constexpr double kShortest = 1e-6;
constexpr double kLeastSine = 0.17364818;  // of 10 degrees

using Points = std::vector<Vector3d>;

// ---- Frames of the body -----------------------------------------------------

// Forward, up, right: X, Y, Z of the ISB.
struct Axes {
  Vector3d x, y, z;

  Vector3d In(const Vector3d& direction) const {
    return {x.dot(direction), y.dot(direction), z.dot(direction)};
  }
};

std::optional<Vector3d> Unit(const Vector3d& vector) {
  const double norm = vector.norm();
  if (!(norm > kShortest)) return std::nullopt;
  return vector / norm;
}

// Two nearly collinear directions span no plane.
std::optional<Vector3d> Normal(const Vector3d& a, const Vector3d& b) {
  const auto unit_a = Unit(a);
  const auto unit_b = Unit(b);
  if (!unit_a || !unit_b) return std::nullopt;
  const Vector3d normal = unit_a->cross(*unit_b);
  if (normal.norm() < kLeastSine) return std::nullopt;
  return normal.normalized();
}

// Y is along `up`; Z is `right` made perpendicular to Y.
std::optional<Axes> AxesByUp(const Vector3d& up, const Vector3d& right) {
  const auto forward = Normal(up, right);
  if (!forward) return std::nullopt;
  const Vector3d y = up.normalized();
  return Axes{*forward, y, forward->cross(y)};
}

// Z is along `right`; Y is `up` made perpendicular to Z.
std::optional<Axes> AxesByRight(const Vector3d& up, const Vector3d& right) {
  const auto forward = Normal(up, right);
  if (!forward) return std::nullopt;
  const Vector3d z = right.normalized();
  return Axes{*forward, z.cross(*forward), z};
}

// Points of the functions below: l_hip, r_hip, l_shoulder, r_shoulder, then the
// knee or elbow of the limb; `side` selects the limb's hip or shoulder.
Vector3d Hips(const Points& p) { return p[1] - p[0]; }
Vector3d Shoulders(const Points& p) { return p[3] - p[2]; }
Vector3d Trunk(const Points& p) {
  return 0.5 * (p[2] + p[3]) - 0.5 * (p[0] + p[1]);
}
size_t HipOf(double side) { return side > 0.0 ? 1 : 0; }
size_t ShoulderOf(double side) { return side > 0.0 ? 3 : 2; }

// ---- Angles in these frames [rad] -------------------------------------------

// Angle about an axis of a unit vector whose components perpendicular to the
// axis are `cosine` and `sine`; nullopt if the vector is within 10 degrees of
// the axis.
std::optional<double> Around(double sine, double cosine) {
  if (std::hypot(sine, cosine) < kLeastSine) return std::nullopt;
  return std::atan2(sine, cosine);
}

// Angle of a unit vector to a plane, from its component normal to the plane.
double Tilt(double sine) { return std::asin(std::clamp(sine, -1.0, 1.0)); }

// A direction in a frame; nullopt where either is undetermined.
std::optional<Vector3d> In(const std::optional<Axes>& axes,
                           const std::optional<Vector3d>& direction) {
  if (!axes || !direction) return std::nullopt;
  return axes->In(*direction);
}

// The thigh, from the knee up to the hip, in the frame of the hips:
// Rz(flexion) Rx(adduction) y.
std::optional<Vector3d> Thigh(const Points& p, double side) {
  return In(AxesByRight(Trunk(p), Hips(p)), Unit(p[HipOf(side)] - p[4]));
}

std::optional<double> HipFlexion(const Points& p, const Vector3d&,
                                 double side) {
  const auto thigh = Thigh(p, side);
  if (!thigh) return std::nullopt;
  return Around(-thigh->x(), thigh->y());
}

std::optional<double> HipAdduction(const Points& p, const Vector3d&,
                                   double side) {
  const auto thigh = Thigh(p, side);
  if (!thigh) return std::nullopt;
  return Tilt(side * thigh->z());
}

std::optional<double> ShoulderPlane(const Points& p, const Vector3d&,
                                    double side) {
  const auto arm =
      In(AxesByUp(Trunk(p), Shoulders(p)), Unit(p[4] - p[ShoulderOf(side)]));
  if (!arm) return std::nullopt;
  return Around(arm->x(), side * arm->z());
}

// The trunk in the frame of the vertical and the hips' heading.
std::optional<Vector3d> Lean(const Points& p, const Vector3d& up) {
  return In(AxesByUp(up, Hips(p)), Unit(Trunk(p)));
}

std::optional<double> TrunkForward(const Points& p, const Vector3d& up,
                                   double) {
  const auto lean = Lean(p, up);
  if (!lean) return std::nullopt;
  return Around(lean->x(), lean->y());
}

std::optional<double> TrunkRight(const Points& p, const Vector3d& up, double) {
  const auto lean = Lean(p, up);
  if (!lean) return std::nullopt;
  return Tilt(lean->z());
}

// Rotation from the hips to the shoulders about the trunk's axis.
std::optional<double> TrunkTurn(const Points& p, const Vector3d&, double) {
  const auto shoulders = In(AxesByUp(Trunk(p), Hips(p)), Unit(Shoulders(p)));
  if (!shoulders) return std::nullopt;
  return Around(shoulders->x(), shoulders->z());
}

// Points: l_hip, r_hip.
std::optional<double> PelvisObliquity(const Points& p, const Vector3d& up,
                                      double) {
  const auto hips = Unit(Hips(p));
  if (!hips) return std::nullopt;
  return Tilt(up.dot(*hips));
}

// ---- Uncertainty ------------------------------------------------------------

double Wrapped(double rad) { return std::remainder(rad, 2.0 * kPi); }

// Standard deviation [rad], by central differences. A step of a micrometre
// leaves ten digits for angles that change by about 3 rad/m.
std::optional<double> SigmaOf(const AngleInFrame& rule, Points points,
                              const std::vector<Matrix3d>& covariances,
                              const Vector3d& up) {
  constexpr double kStep = 1e-6;  // m
  double variance = 0.0;
  for (size_t i = 0; i < points.size(); ++i) {
    Vector3d gradient;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const double at = points[i][axis];
      points[i][axis] = at + kStep;
      const auto above = rule.measure(points, up, rule.side);
      points[i][axis] = at - kStep;
      const auto below = rule.measure(points, up, rule.side);
      points[i][axis] = at;
      if (!above || !below) return std::nullopt;
      gradient[axis] = Wrapped(*above - *below) / (2.0 * kStep);
    }
    variance += gradient.dot(covariances[i] * gradient);
  }
  return std::sqrt(std::max(0.0, variance));
}

void AddInterval(const AngleInFrame& rule, const Points& points,
                 const std::vector<Matrix3d>& covariances, const Vector3d& up,
                 AngleEstimate* estimate) {
  const auto sigma = SigmaOf(rule, points, covariances, up);
  if (!sigma) return;
  const double half_deg = kSigmas * *sigma * kDegPerRad;
  estimate->low_deg = estimate->deg - half_deg;
  estimate->high_deg = estimate->deg + half_deg;
  if (rule.low_deg == rule.high_deg) return;
  estimate->low_deg = std::max(*estimate->low_deg, rule.low_deg);
  estimate->high_deg = std::min(*estimate->high_deg, rule.high_deg);
}

Vector3d Sum(const std::vector<double>& weights, const Points& points) {
  Vector3d sum = Vector3d::Zero();
  for (size_t i = 0; i < points.size(); ++i) sum += weights[i] * points[i];
  return sum;
}

// Two directions with the angle between them.
struct Pair {
  Vector3d from, to;  // unit
  double from_m = 0.0, to_m = 0.0;
  double rad = 0.0;

  static std::optional<Pair> Of(const AngleBetween& rule,
                                const Points& points) {
    const Vector3d from = Sum(rule.from, points);
    const Vector3d to = Sum(rule.to, points);
    const auto unit_from = Unit(from);
    const auto unit_to = Unit(to);
    if (!unit_from || !unit_to) return std::nullopt;
    // atan2 is accurate for small angles, where acos loses half of the digits.
    const double rad =
        std::atan2(unit_from->cross(*unit_to).norm(), unit_from->dot(*unit_to));
    return Pair{*unit_from, *unit_to, from.norm(), to.norm(), rad};
  }
};

// Covariance [rad^2] of the error in the plane of the two directions, which is
// the error of the angle, and of the error perpendicular to this plane.
Eigen::Matrix2d PlaneCovariance(const AngleBetween& rule, const Pair& pair,
                                const std::vector<Matrix3d>& covariances) {
  // For collinear directions any plane through them is valid.
  Vector3d across = pair.from.cross(pair.to);
  if (across.norm() < 1e-9) across = pair.from.unitOrthogonal();
  across.normalize();
  // Derivative of the angle by either direction.
  const Vector3d by_from = -across.cross(pair.from);
  const Vector3d by_to = across.cross(pair.to);
  // The error perpendicular to the plane is the difference of the directions'
  // errors or, if they are 90 degrees or more apart, the sum.
  const double apart = pair.rad < kPi / 2.0 ? 1.0 : -1.0;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  for (size_t i = 0; i < covariances.size(); ++i) {
    const double from = rule.from[i] / pair.from_m;
    const double to = rule.to[i] / pair.to_m;
    Eigen::Matrix<double, 2, 3> jacobian;
    jacobian.row(0) = (from * by_from + to * by_to).transpose();
    jacobian.row(1) = ((to - apart * from) * across).transpose();
    covariance += jacobian * covariances[i] * jacobian.transpose();
  }
  return covariance;
}

// An angle between two directions is within 0 .. 180 degrees: for nearly
// collinear directions the error perpendicular to the plane moves the angle
// away from that end, and half the interval is the radius of a disc.
void AddInterval(const AngleBetween& rule, const Pair& pair,
                 const std::vector<Matrix3d>& covariances,
                 AngleEstimate* estimate) {
  const Eigen::Matrix2d covariance = PlaneCovariance(rule, pair, covariances);
  const double mean = 0.5 * covariance.trace();
  const double largest =
      mean +
      std::hypot(0.5 * (covariance(0, 0) - covariance(1, 1)), covariance(0, 1));
  const double disc = kDiscSigmas * std::sqrt(std::max(0.0, largest));
  const double to_line = std::min(pair.rad, kPi - pair.rad);
  const double half =
      to_line < disc ? disc
                     : kSigmas * std::sqrt(std::max(0.0, covariance(0, 0)));
  const double low = std::max(0.0, pair.rad - half) * kDegPerRad;
  const double high = std::min(kPi, pair.rad + half) * kDegPerRad;
  const double a = rule.offset_deg + rule.factor * low;
  const double b = rule.offset_deg + rule.factor * high;
  estimate->low_deg = std::min(a, b);
  estimate->high_deg = std::max(a, b);
}

// ---- Angles of a skeleton ---------------------------------------------------

using Names = std::vector<std::string>;

void Add(const Skeleton& skeleton, const std::string& name, const Names& joints,
         std::variant<AngleBetween, AngleInFrame> rule,
         std::vector<JointAngle>* angles) {
  JointAngle angle;
  angle.name = name;
  for (const std::string& joint : joints) {
    angle.joints.push_back(skeleton.IndexOf(joint));
    if (angle.joints.back() < 0) return;
  }
  angle.rule = std::move(rule);
  angles->push_back(std::move(angle));
}

// The flexion of a chain of three joints.
AngleBetween Bend() { return {{-1.0, 1.0, 0.0}, {0.0, -1.0, 1.0}, 0.0, 1.0}; }

// Between shin and sole; positive with toes up.
AngleBetween Ankle() {
  return {{-1.0, 1.0, 0.0, 0.0}, {0.0, 0.0, -1.0, 1.0}, 90.0, -1.0};
}

// Between the upper arm and the downward axis of the trunk.
AngleBetween Elevation(double side) {
  AngleBetween rule = {{0.0, 0.0, 0.0, 0.0, 1.0}, {0.5, 0.5, -0.5, -0.5, 0.0}};
  rule.from[ShoulderOf(side)] = -1.0;
  return rule;
}

const Names& TrunkJoints() {
  static const Names kJoints = {"l_hip", "r_hip", "l_shoulder", "r_shoulder"};
  return kJoints;
}

Names TrunkAnd(const std::string& joint) {
  Names joints = TrunkJoints();
  joints.push_back(joint);
  return joints;
}

void AddSide(const Skeleton& skeleton, double side,
             std::vector<JointAngle>* angles) {
  const std::string start = side > 0.0 ? "r_" : "l_";
  const auto add = [&](const std::string& name, const Names& joints,
                       std::variant<AngleBetween, AngleInFrame> rule) {
    Add(skeleton, start + name, joints, std::move(rule), angles);
  };
  const std::string knee = start + "knee", elbow = start + "elbow";
  // MediaPipe has no big_toe; its foot_index is defined differently.
  const bool has_toe = skeleton.IndexOf(start + "big_toe") >= 0;
  const std::string toe = start + (has_toe ? "big_toe" : "foot_index");
  add("hip_flexion", TrunkAnd(knee), AngleInFrame{HipFlexion, side});
  add("hip_adduction", TrunkAnd(knee),
      AngleInFrame{HipAdduction, side, -90.0, 90.0});
  add("knee_flexion", {start + "hip", knee, start + "ankle"}, Bend());
  add("ankle_dorsiflexion", {start + "ankle", knee, start + "heel", toe},
      Ankle());
  add("shoulder_elevation", TrunkAnd(elbow), Elevation(side));
  add("shoulder_plane", TrunkAnd(elbow), AngleInFrame{ShoulderPlane, side});
  add("elbow_flexion", {start + "shoulder", elbow, start + "wrist"}, Bend());
}

}  // namespace

std::vector<JointAngle> AnglesOf(const Skeleton& skeleton) {
  std::vector<JointAngle> angles;
  AddSide(skeleton, -1.0, &angles);
  AddSide(skeleton, 1.0, &angles);
  Add(skeleton, "trunk_forward", TrunkJoints(), AngleInFrame{TrunkForward},
      &angles);
  Add(skeleton, "trunk_right", TrunkJoints(),
      AngleInFrame{TrunkRight, 1.0, -90.0, 90.0}, &angles);
  Add(skeleton, "trunk_turn", TrunkJoints(), AngleInFrame{TrunkTurn}, &angles);
  Add(skeleton, "pelvis_obliquity", {"l_hip", "r_hip"},
      AngleInFrame{PelvisObliquity, 1.0, -90.0, 90.0}, &angles);
  for (JointAngle& angle : angles) {
    const auto* rule = std::get_if<AngleInFrame>(&angle.rule);
    angle.needs_up = rule != nullptr && (rule->measure == TrunkForward ||
                                         rule->measure == TrunkRight ||
                                         rule->measure == PelvisObliquity);
  }
  return angles;
}

std::optional<AngleEstimate> MeasureAngle(const JointAngle& angle,
                                          const PersonPose& person,
                                          const Vector3d& up) {
  Points points;
  std::vector<Matrix3d> covariances;
  AngleEstimate estimate;
  estimate.observed = true;
  for (const int idx : angle.joints) {
    const auto j = static_cast<size_t>(idx);
    const Joint3d& joint = person.joints[j];
    if (!joint.present()) return std::nullopt;
    points.push_back(joint.position_m);
    estimate.observed &= joint.status == JointStatus::kObserved;
    if (!person.covariances.empty() && person.covariances[j].has_value()) {
      covariances.push_back(*person.covariances[j]);
    }
  }
  const bool known = covariances.size() == points.size();
  if (const auto* rule = std::get_if<AngleBetween>(&angle.rule)) {
    const auto pair = Pair::Of(*rule, points);
    if (!pair) return std::nullopt;
    estimate.deg = rule->offset_deg + rule->factor * pair->rad * kDegPerRad;
    if (known) AddInterval(*rule, *pair, covariances, &estimate);
    return estimate;
  }
  const AngleInFrame& rule = std::get<AngleInFrame>(angle.rule);
  const auto rad = rule.measure(points, up, rule.side);
  if (!rad) return std::nullopt;
  estimate.deg = *rad * kDegPerRad;
  if (known) AddInterval(rule, points, covariances, up, &estimate);
  return estimate;
}

}  // namespace kinegraph
