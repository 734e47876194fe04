// The articulated body of a synthetic person: rigid segments of constant size,
// the posture that places them, and the occlusion they cause.
//
// Frames: x forward, y to the person's left, z up when standing upright.
#ifndef KINEGRAPH_CORE_SYNTHETIC_BODY_H_
#define KINEGRAPH_CORE_SYNTHETIC_BODY_H_

#include <Eigen/Core>
#include <array>
#include <vector>

#include "core/skeleton/skeleton.h"

namespace kinegraph {

// Left before right.
enum Side { kLeft = 0, kRight = 1 };

// +1 on the left, -1 on the right: the sign of y.
inline double SignOf(int side) { return side == kLeft ? 1.0 : -1.0; }

// Rigid parts; Sided(part, side) selects the left or the right one of a pair.
enum class Segment {
  kPelvis,  // origin: middle of the hip joints
  kThorax,  // same origin; rotates about the spine
  kHead,    // origin: neck
  kUpperArm,
  kRightUpperArm,
  kForearm,  // with the hand
  kRightForearm,
  kThigh,
  kRightThigh,
  kShank,
  kRightShank,
  kFoot,
  kRightFoot,
};
inline constexpr int kSegmentCount = 13;

inline Segment Sided(Segment left, int side) {
  return static_cast<Segment>(static_cast<int>(left) + side);
}

// Lengths of one person [m]. The two sides are equal.
struct BodyShape {
  double stature = 1.72;
  double thigh = 0.0;
  double shank = 0.0;
  double ankle_height = 0.0;
  double hip_half_width = 0.0;
  double neck_height = 0.0;      // above the hips
  double shoulder_height = 0.0;  // above the hips
  double shoulder_half_width = 0.0;
  double upper_arm = 0.0;
  double forearm = 0.0;
  double foot_length = 0.0;
  double head_height = 0.0;  // neck to top

  double leg() const { return thigh + shank; }
};

// Segment lengths as shares of the stature, after Drillis and Contini (1966) in
// Winter, Biomechanics and Motor Control of Human Movement, fig. 4.1; widths
// are between joint centres. `leg_share` scales the legs (1: average).
BodyShape MakeBodyShape(double stature_m, double leg_share);

struct ArmPosture {
  double flexion = 0.0;    // upper arm forward of hanging [rad]
  double abduction = 0.0;  // upper arm away from the trunk [rad]
  double rotation = 0.0;   // upper arm about its axis, forearm inwards [rad]
  double elbow = 0.0;      // 0: straight [rad]
};

struct FootPosture {
  Eigen::Vector3d ankle_m = Eigen::Vector3d::Zero();  // requested, world
  double yaw = 0.0;    // direction of the toes about world z [rad]
  double pitch = 0.0;  // toes down is positive [rad]
};

// All variables of a posture.
struct Posture {
  Eigen::Vector3d pelvis_m = Eigen::Vector3d::Zero();  // world
  double heading = 0.0;     // of the pelvis about world z [rad]
  double lean = 0.0;        // trunk forward about the hip axis [rad]
  double twist = 0.0;       // thorax against pelvis about the spine [rad]
  double head_yaw = 0.0;    // to the left [rad]
  double head_pitch = 0.0;  // downwards [rad]
  std::array<ArmPosture, 2> arms;
  std::array<FootPosture, 2> feet;
};

struct SegmentPose {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();  // world_from_segment
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();
};
using BodyPose = std::array<SegmentPose, kSegmentCount>;

// Places all segments. The knees follow from the requested ankles; an ankle out
// of the leg's reach is approached as far as possible without abrupt changes.
BodyPose PlaceBody(const BodyShape& shape, const Posture& posture);

// A point fixed to a segment.
struct BodyPoint {
  Segment segment = Segment::kPelvis;
  Eigen::Vector3d offset_m = Eigen::Vector3d::Zero();
};

inline Eigen::Vector3d PositionOf(const BodyPoint& point,
                                  const BodyPose& pose) {
  const SegmentPose& segment = pose[static_cast<size_t>(point.segment)];
  return segment.origin_m + segment.R * point.offset_m;
}

// One point per joint of the skeleton, by the joint's name. Throws
// OptionError("skeleton", ...) for an unknown name; the joints of all built-in
// skeletons are known.
std::vector<BodyPoint> PointsOf(const BodyShape& shape,
                                const Skeleton& skeleton);

// Squared distance between the segments [p0, p1] and [q0, q1].
double SquaredSegmentDistance(const Eigen::Vector3d& p0,
                              const Eigen::Vector3d& p1,
                              const Eigen::Vector3d& q0,
                              const Eigen::Vector3d& q1);

// A body part that occludes what is behind it: everything within `radius_m` of
// the line from a to b, in the world.
struct Capsule {
  Eigen::Vector3d a = Eigen::Vector3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  double radius_m = 0.0;
};

// A body as an occluder.
class Obstacle {
 public:
  // `centre`: near the middle of the capsules.
  Obstacle(std::vector<Capsule> capsules, const Eigen::Vector3d& centre);

  // Whether the body blocks the line of sight between two points.
  bool Hides(const Eigen::Vector3d& eye, const Eigen::Vector3d& point) const;

 private:
  std::vector<Capsule> capsules_;
  Eigen::Vector3d centre_;  // of a bounding sphere
  double radius_m_ = 0.0;
};

Obstacle ObstacleOf(const BodyShape& shape, const BodyPose& pose);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_SYNTHETIC_BODY_H_
