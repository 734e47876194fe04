#include "solvers/noise/bias_model.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace kinegraph {
namespace {

bool HasSide(const std::string& name) {
  return name.size() > 2 && name[1] == '_' &&
         (name[0] == 'l' || name[0] == 'r');
}

// Axes with the given up, and left as close to `left` as possible.
std::optional<BodyAxes> AxesOf(const Eigen::Vector3d& up,
                               const Eigen::Vector3d& left) {
  constexpr double kLeast_m = 0.05;
  BodyAxes axes;
  if (!(up.norm() > kLeast_m)) return std::nullopt;
  axes.up = up.normalized();
  const Eigen::Vector3d across = left - axes.up * axes.up.dot(left);
  if (!(across.norm() > kLeast_m)) return std::nullopt;
  axes.left = across.normalized();
  axes.forward = axes.left.cross(axes.up);
  return axes;
}

}  // namespace

BiasJoints::BiasJoints(const Skeleton& skeleton) {
  const auto pair = [&skeleton](const std::string& part) -> Pair {
    return {skeleton.IndexOf("l_" + part), skeleton.IndexOf("r_" + part)};
  };
  shoulders_ = pair("shoulder");
  hips_ = pair("hip");
  ears_ = pair("ear");
  for (int j = 0; j < skeleton.joint_count(); ++j) {
    const std::string& name = skeleton.joints()[j];
    const std::string part = HasSide(name) ? name.substr(2) : name;
    const auto at = std::find(names_.begin(), names_.end(), part);
    index_.push_back(static_cast<int>(at - names_.begin()));
    if (at == names_.end()) {
      names_.push_back(part);
      classes_.push_back(skeleton.joint_class(j));
    }
    side_.push_back(HasSide(name) && name[0] == 'r' ? -1.0 : 1.0);
    on_head_.push_back(skeleton.joint_class(j) == JointClass::kHead);
  }
}

std::optional<BodyStance> BiasJoints::StanceOf(const PositionOf& at) const {
  struct Both {
    Eigen::Vector3d left, right;
  };
  const auto both = [&at](const Pair& pair) -> std::optional<Both> {
    if (pair[0] < 0 || pair[1] < 0) return std::nullopt;
    const auto left = at(pair[0]);
    const auto right = at(pair[1]);
    if (!left.has_value() || !right.has_value()) return std::nullopt;
    return Both{*left, *right};
  };
  const auto shoulders = both(shoulders_);
  const auto hips = both(hips_);
  if (!shoulders.has_value() || !hips.has_value()) return std::nullopt;
  const Eigen::Vector3d up =
      0.5 * (shoulders->left + shoulders->right - hips->left - hips->right);
  const auto trunk =
      AxesOf(up, shoulders->left - shoulders->right + hips->left - hips->right);
  if (!trunk.has_value()) return std::nullopt;
  const auto ears = both(ears_);
  const auto head =
      ears.has_value() ? AxesOf(up, ears->left - ears->right) : std::nullopt;
  return BodyStance{*trunk, head.value_or(*trunk)};
}

std::optional<ViewDirection> DirectionOf(const BiasJoints& joints,
                                         const BodyStance& stance,
                                         int joint_idx,
                                         const Eigen::Vector3d& point_m,
                                         const Camera& camera) {
  const BodyAxes& axes = joints.OnHead(joint_idx) ? stance.head : stance.trunk;
  Matrix23d jacobian;
  if (!camera.Project(point_m, &jacobian).has_value()) return std::nullopt;
  const double px_per_m = camera.focal_px() / camera.Depth(point_m);
  const Eigen::Vector2d along = jacobian * axes.up;
  constexpr double kLeast = 0.2;  // relative length of the trunk in the image
  if (!(along.norm() > kLeast * px_per_m)) return std::nullopt;
  const double side = joints.SideOf(joint_idx);
  ViewDirection direction;
  direction.along_px = px_per_m * along.normalized();
  direction.across_px =
      side * Eigen::Vector2d(-direction.along_px.y(), direction.along_px.x());
  const Eigen::Vector3d view = (camera.centre() - point_m).normalized();
  direction.azimuth = std::atan2(view.dot(axes.left), view.dot(axes.forward));
  direction.body << axes.forward, side * axes.left, axes.up;
  const double p = side * direction.azimuth;
  const double e = view.dot(axes.up);
  direction.features << 1.0, std::cos(p), std::sin(p), std::cos(2.0 * p),
      std::sin(2.0 * p), std::cos(3.0 * p), std::sin(3.0 * p), e,
      e * std::cos(p), e * std::sin(p);
  return direction;
}

Eigen::Vector2d BiasOf(const ViewBias::OfJoint& bias,
                       const ViewDirection& direction) {
  if (!bias.used) return Eigen::Vector2d::Zero();
  double across_m = 0.0;
  double along_m = 0.0;
  for (int i = 0; i < kViewFeatureCount; ++i) {
    across_m += bias.across_m[i] * direction.features[i];
    along_m += bias.along_m[i] * direction.features[i];
  }
  return across_m * direction.across_px + along_m * direction.along_px;
}

ViewBias InOrderOf(const std::vector<std::string>& names,
                   const ViewBias& bias) {
  ViewBias ordered;
  ordered.azimuth_deg = bias.azimuth_deg;
  for (const std::string& name : names) {
    ViewBias::OfJoint& mine = ordered.joints.emplace_back();
    mine.joint = name;
    for (const ViewBias::OfJoint& one : bias.joints) {
      if (one.joint == name) mine = one;
    }
  }
  return ordered;
}

DetectionPredictor::DetectionPredictor(const Skeleton& skeleton,
                                       const ViewBias& bias)
    : joints_(skeleton), bias_(InOrderOf(joints_.names(), bias)) {}

Eigen::Vector2d DetectionPredictor::BiasOf(const PersonPose& person,
                                           int joint_idx,
                                           const Camera& camera) const {
  const Eigen::Vector2d none = Eigen::Vector2d::Zero();
  const auto position = [&person](int j) -> std::optional<Eigen::Vector3d> {
    const Joint3d& joint = person.joints[j];
    if (!joint.present()) return std::nullopt;
    return joint.position_m;
  };
  const auto point = position(joint_idx);
  if (!point.has_value()) return none;
  const auto stance = joints_.StanceOf(position);
  if (!stance.has_value()) return none;
  const auto direction =
      DirectionOf(joints_, *stance, joint_idx, *point, camera);
  if (!direction.has_value()) return none;
  return kinegraph::BiasOf(bias_.joints[joints_.IndexOf(joint_idx)],
                           *direction);
}

}  // namespace kinegraph
