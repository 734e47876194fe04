// The model behind ViewBias (core/data/view_bias.h): the detector's bias as a
// function of the viewing direction. The detected pixel of joint X is
//
//   u = project(X) + (f / z) (s b_across e_across + b_along e_along)
//   b = C [1, cos p, sin p, cos 2p, sin 2p, cos 3p, sin 3p, e, e cos p, e sin
//   p]
//
// f / z: focal length [px] over depth [m]. p: azimuth of the camera in the
// body's frame, positive towards the joint's side (towards the left for joints
// without a side); e: the component along the trunk of the unit vector from the
// joint to the camera. e_along is the unit vector along the trunk's image,
// e_across is perpendicular to it; s is -1 for joints of the right side and 1
// for all others, so that left and right share the coefficients C [m], 2x10:
// rows across and along. Joints of the head use the head's axes instead of the
// trunk's.
#ifndef KINEGRAPH_SOLVERS_NOISE_BIAS_MODEL_H_
#define KINEGRAPH_SOLVERS_NOISE_BIAS_MODEL_H_

#include <Eigen/Core>
#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/data/pose.h"
#include "core/data/view_bias.h"
#include "core/geometry/camera.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph {

// Directions of a body, orthonormal: forward, left, up.
struct BodyAxes {
  Eigen::Vector3d forward = Eigen::Vector3d::UnitX();
  Eigen::Vector3d left = Eigen::Vector3d::UnitY();
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
};

// Axes of the trunk and of the head (equal to the trunk's if the ears do not
// determine them).
struct BodyStance {
  BodyAxes trunk;
  BodyAxes head;
};

// Maps joints to coefficients, which left and right share.
class BiasJoints {
 public:
  explicit BiasJoints(const Skeleton& skeleton);

  // Names without side, in the order of their first joints.
  const std::vector<std::string>& names() const { return names_; }
  // Index of the joint's name in names().
  int IndexOf(int joint_idx) const { return index_[joint_idx]; }
  // -1 for joints of the right side, 1 for all others.
  double SideOf(int joint_idx) const { return side_[joint_idx]; }
  bool OnHead(int joint_idx) const { return on_head_[joint_idx]; }
  // One per name.
  const std::vector<JointClass>& classes() const { return classes_; }

  // The stance from shoulders and hips, for the head also from the ears;
  // nullopt if `at` lacks a shoulder or hip or they do not determine the axes
  // of the trunk.
  using PositionOf =
      std::function<std::optional<Eigen::Vector3d>(int joint_idx)>;
  std::optional<BodyStance> StanceOf(const PositionOf& at) const;

 private:
  std::vector<std::string> names_;
  std::vector<JointClass> classes_;
  std::vector<int> index_;
  std::vector<double> side_;
  std::vector<bool> on_head_;
  using Pair = std::array<int, 2>;  // left, right; -1: none
  Pair shoulders_;
  Pair hips_;
  Pair ears_;
};

// The factors of a joint's coefficients in one view.
struct ViewDirection {
  Eigen::Matrix<double, kViewFeatureCount, 1> features;
  // Pixels per metre across and along.
  Eigen::Vector2d across_px = Eigen::Vector2d::Zero();
  Eigen::Vector2d along_px = Eigen::Vector2d::Zero();
  // Columns: forward, the joint's own side, up.
  Eigen::Matrix3d body = Eigen::Matrix3d::Identity();
  double azimuth = 0.0;  // of the camera around the body, not mirrored [rad]
};

// nullopt if the camera does not see the point or looks along the trunk.
std::optional<ViewDirection> DirectionOf(const BiasJoints& joints,
                                         const BodyStance& stance,
                                         int joint_idx,
                                         const Eigen::Vector3d& point_m,
                                         const Camera& camera);

// The bias of a joint [px]; zero if unused.
Eigen::Vector2d BiasOf(const ViewBias::OfJoint& bias,
                       const ViewDirection& direction);

// The same bias with an entry for each of `names`, unused if `bias` has none.
ViewBias InOrderOf(const std::vector<std::string>& names, const ViewBias& bias);

// Predicts the detector's bias for the joints of poses, in any camera.
class DetectionPredictor {
 public:
  DetectionPredictor(const Skeleton& skeleton, const ViewBias& bias);
  // [px]; zero if the joint is missing, its bias is unused, the pose does not
  // determine the body's orientation, or DirectionOf returns nullopt.
  Eigen::Vector2d BiasOf(const PersonPose& person, int joint_idx,
                         const Camera& camera) const;

 private:
  BiasJoints joints_;
  ViewBias bias_;  // in the order of the joints' names
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_NOISE_BIAS_MODEL_H_
