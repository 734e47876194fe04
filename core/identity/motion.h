// Motion as evidence: how likely it is that a person moved from one state to
// another in the time between them.
#ifndef KINEGRAPH_CORE_IDENTITY_MOTION_H_
#define KINEGRAPH_CORE_IDENTITY_MOTION_H_

#include <Eigen/Core>
#include <vector>

#include "core/identity/posture.h"
#include "core/identity/tracklet.h"

namespace kinegraph {

// Motion across a gap: an Ornstein-Uhlenbeck process of the velocity (time
// constant one second) on each axis of the floor, within the occupied space.
// Its scale depends on the activity (stand, shuffle, stroll, stride), which is
// inferred from the velocity before the gap and persists for one or two
// seconds. The predicted position and velocity, with covariance, are compared
// with the alternative that one person left and another arrived, anywhere. A
// standing person mostly keeps facing the same way, and limbs keep their
// posture across a short gap (PostureModel). The share of people who left and
// returned grows with the gap.
class IdentityMotion {
 public:
  // The floor is the plane in which people spread most; the occupied space is
  // the rectangle around the centres of all people, plus half a metre.
  explicit IdentityMotion(const std::vector<Tracklet>& tracklets);

  // Log likelihood ratio [nats] of the state `to`, for the person in `from`
  // against another. The gap counts as at least `frame_s`, even if `to` is not
  // later.
  double LogRatio(const MotionState& from, const MotionState& to,
                  double frame_s) const;

 private:
  // Log likelihood ratio [nats] of the heading in `to`, for the person in
  // `from` against another.
  double LogTurn(const MotionState& from, const MotionState& to,
                 double gap_s) const;
  Eigen::Vector2d OnFloor(const Eigen::Vector3d& position_m) const {
    return floor_ * (position_m - origin_m_);
  }

  Eigen::Vector2d low_m_ = Eigen::Vector2d::Zero();  // on the floor
  Eigen::Vector2d high_m_ = Eigen::Vector2d::Zero();
  Eigen::Vector3d origin_m_ = Eigen::Vector3d::Zero();
  Eigen::Matrix<double, 2, 3> floor_ = Eigen::Matrix<double, 2, 3>::Zero();
  PostureModel postures_;  // how similar the postures of different people are
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IDENTITY_MOTION_H_
