// Joint angles from positions alone, with 95 % intervals if the joints have
// covariances.
//
// Axes follow the ISB: X forward, Y up, Z to the person's right. In upright
// standing with hanging arms all angles are 0 but shoulder_plane, which is
// undefined. docs/kinematics.md has every definition and explains what
// positions cannot determine.
#ifndef KINEGRAPH_CORE_KINEMATICS_ANGLES_H_
#define KINEGRAPH_CORE_KINEMATICS_ANGLES_H_

#include <Eigen/Core>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/data/pose.h"

namespace kinegraph {

// The angle between two directions, each a weighted sum of positions:
// `offset_deg` + `factor` times 0 .. 180 degrees.
struct AngleBetween {
  std::vector<double> from;  // one per joint of the angle; the sum is 0
  std::vector<double> to;
  double offset_deg = 0.0;
  double factor = 1.0;
};

// An angle in a frame of the body [rad]; nullopt where it is undefined.
struct AngleInFrame {
  using Measure =
      std::optional<double> (*)(const std::vector<Eigen::Vector3d>& points,
                                const Eigen::Vector3d& up, double side);
  Measure measure = nullptr;
  double side = 1.0;      // 1 on the right, -1 on the left
  double low_deg = 0.0;   // range of the angle, which clamps intervals;
  double high_deg = 0.0;  // both 0: the angle is cyclic
};

struct JointAngle {
  std::string name;         // "l_knee_flexion"
  std::vector<int> joints;  // of the skeleton, in the order of the rule
  bool needs_up = false;    // else independent of the world's orientation
  std::variant<AngleBetween, AngleInFrame> rule;
};

struct AngleEstimate {
  double deg = 0.0;
  bool observed = false;  // all of its joints are observed
  // Ends of the 95 % interval, when all of its joints have a covariance.
  std::optional<double> low_deg;
  std::optional<double> high_deg;
};

// The angles for which a skeleton has the joints: of the left side, the right
// side, the trunk and the pelvis.
std::vector<JointAngle> AnglesOf(const Skeleton& skeleton);

// nullopt when a joint is missing or the angle is undefined in this pose. The
// covariances are propagated to first order, assuming that those of different
// joints are independent. `up` is a unit vector.
std::optional<AngleEstimate> MeasureAngle(const JointAngle& angle,
                                          const PersonPose& person,
                                          const Eigen::Vector3d& up);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_KINEMATICS_ANGLES_H_
