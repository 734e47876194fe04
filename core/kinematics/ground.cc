#include "core/kinematics/ground.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/base/error.h"

namespace kinegraph {
namespace {

constexpr double kAnkleHeightM = 0.08;

Eigen::Vector3d Snapped(const Eigen::Vector3d& direction) {
  constexpr double kSnap_deg = 25.0;
  return NearestAxis(direction, kSnap_deg).value_or(direction.normalized());
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

std::optional<Eigen::Vector3d> UpDirection(const TrackSequence& tracks,
                                           const UpEvidence& known) {
  const auto up = StanceOf(tracks.header.skeleton, tracks.frames).Up(known);
  if (!up.has_value()) return std::nullopt;
  return Snapped(*up);
}

double FloorHeight(const TrackSequence& tracks, const Eigen::Vector3d& up) {
  const Skeleton& skeleton = tracks.header.skeleton;
  std::vector<double> lowest;
  for (const TrackFrame& frame : tracks.frames) {
    for (const PersonPose& person : frame.people) {
      double low = std::numeric_limits<double>::infinity();
      for (size_t j = 0; j < person.joints.size(); ++j) {
        if (!person.joints[j].present()) continue;
        const bool is_ankle =
            skeleton.joint_class(static_cast<int>(j)) == JointClass::kAnkle;
        low = std::min(low, up.dot(person.joints[j].position_m) -
                                (is_ankle ? kAnkleHeightM : 0.0));
      }
      if (std::isfinite(low)) lowest.push_back(low);
    }
  }
  if (lowest.empty()) return 0.0;
  const auto at = lowest.begin() + static_cast<long>(lowest.size() / 50);
  std::nth_element(lowest.begin(), at, lowest.end());
  return *at;
}

}  // namespace kinegraph
