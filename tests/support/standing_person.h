// A BODY_25 person who stands upright at the origin, with known joint angles.
#ifndef KINEGRAPH_TESTS_SUPPORT_STANDING_PERSON_H_
#define KINEGRAPH_TESTS_SUPPORT_STANDING_PERSON_H_

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "core/data/pose.h"

namespace kinegraph::testing {

// In metres. The person faces +x, y is to the left, z is up; limbs are
// straight, soles horizontal.
class PosedPerson {
 public:
  PosedPerson() {
    pose_.joints.resize(static_cast<size_t>(Body25().joint_count()));
    for (const double side : {1.0, -1.0}) {
      const std::string s = side > 0.0 ? "l_" : "r_";
      Put(s + "hip", {0.0, 0.1 * side, 1.0});
      Put(s + "knee", {0.0, 0.1 * side, 0.5});
      Put(s + "ankle", {0.0, 0.1 * side, 0.1});
      Put(s + "heel", {-0.05, 0.1 * side, 0.03});
      Put(s + "big_toe", {0.2, 0.1 * side, 0.03});
      Put(s + "shoulder", {0.0, 0.2 * side, 1.5});
      Put(s + "elbow", {0.0, 0.2 * side, 1.2});
      Put(s + "wrist", {0.0, 0.2 * side, 0.95});
    }
  }

  static size_t Index(const std::string& joint) {
    return static_cast<size_t>(Body25().IndexOf(joint));
  }
  const Eigen::Vector3d& At(const std::string& joint) const {
    return pose_.joints[Index(joint)].position_m;
  }
  void Put(const std::string& joint, const Eigen::Vector3d& position_m) {
    pose_.joints[Index(joint)] = {position_m, JointStatus::kObserved};
  }
  void Remove(const std::string& joint) { pose_.joints[Index(joint)] = {}; }

  // Rotates joints about an axis through the first of them (right-hand rule).
  void Turn(const std::vector<std::string>& joints, double deg,
            const Eigen::Vector3d& axis) {
    TurnAbout(At(joints.front()), joints, deg, axis);
  }
  void TurnAbout(const Eigen::Vector3d& centre,
                 const std::vector<std::string>& joints, double deg,
                 const Eigen::Vector3d& axis) {
    const Eigen::AngleAxisd turn(deg * 3.14159265358979323846 / 180.0, axis);
    for (const std::string& joint : joints) {
      Put(joint, centre + turn * (At(joint) - centre));
    }
  }

  PersonPose& pose() { return pose_; }
  const PersonPose& pose() const { return pose_; }

 private:
  PersonPose pose_;
};

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_SUPPORT_STANDING_PERSON_H_
