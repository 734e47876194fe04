#include "core/kinematics/ground.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/base/error.h"

namespace kinegraph {
namespace {

constexpr double kSnapDegrees = 25.0;
constexpr double kAnkleHeightM = 0.08;
constexpr double kPi = 3.14159265358979323846;

// Mean of the class's joints; nullopt when none is there.
std::optional<Eigen::Vector3d> Centre(const Skeleton& skeleton,
                                      const Pose3d& pose, JointClass wanted) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
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

Eigen::Vector3d Snapped(const Eigen::Vector3d& direction) {
  const Eigen::Vector3d unit = direction.normalized();
  Eigen::Index axis = 0;
  const double cosine = unit.cwiseAbs().maxCoeff(&axis);
  if (cosine < std::cos(kSnapDegrees * kPi / 180.0)) return unit;
  return std::copysign(1.0, unit[axis]) * Eigen::Vector3d::Unit(axis);
}

}  // namespace

std::optional<Eigen::Vector3d> ParseUp(const std::string& text,
                                       const std::string& what) {
  if (text == "auto") return std::nullopt;
  const std::string axis =
      text.empty() || text[0] != '-' ? text : text.substr(1);
  const size_t index = std::string("xyz").find(axis);
  if (axis.size() != 1 || index == std::string::npos) {
    throw InputError(what + ": found '" + Printable(text) +
                     "', expected auto, x, y, z, -x, -y or -z");
  }
  const double sign = text[0] == '-' ? -1.0 : 1.0;
  return sign * Eigen::Vector3d::Unit(static_cast<Eigen::Index>(index));
}

Eigen::Vector3d UpDirection(const TrackSequence& tracks,
                            const CameraRig& cameras) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const TrackFrame& frame : tracks.frames) {
    for (const PersonPose& person : frame.people) {
      const Skeleton& skeleton = tracks.header.skeleton;
      const auto low = Centre(skeleton, person.joints, JointClass::kAnkle);
      const auto high = Centre(skeleton, person.joints, JointClass::kShoulder);
      if (low.has_value() && high.has_value()) sum += *high - *low;
    }
  }
  if (sum.norm() > 0.0) return Snapped(sum);
  for (const Camera& camera : cameras) sum -= camera.R().row(1).transpose();
  return sum.norm() > 0.0 ? Snapped(sum) : Eigen::Vector3d::UnitZ();
}

double FloorHeight(const TrackSequence& tracks, const Eigen::Vector3d& up) {
  std::vector<double> lowest;
  for (const TrackFrame& frame : tracks.frames) {
    for (const PersonPose& person : frame.people) {
      double low = std::numeric_limits<double>::infinity();
      for (const Joint3d& joint : person.joints) {
        if (joint.present()) low = std::min(low, up.dot(joint.position_m));
      }
      if (std::isfinite(low)) lowest.push_back(low);
    }
  }
  if (lowest.empty()) return 0.0;
  const auto at = lowest.begin() + static_cast<long>(lowest.size() / 50);
  std::nth_element(lowest.begin(), at, lowest.end());
  return *at - kAnkleHeightM;
}

}  // namespace kinegraph
