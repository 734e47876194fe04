// Could somebody have come from there to here in that time.
#ifndef KINEGRAPH_CORE_IDENTITY_MOTION_H_
#define KINEGRAPH_CORE_IDENTITY_MOTION_H_

#include <Eigen/Core>
#include <vector>

#include "core/identity/tracklet.h"

namespace kinegraph {

struct MotionState {
  TimeNs time = 0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  // of the trunk, world
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
};

// Where a tracklet's clean frames begin and end: a line through the outermost
// 0.3 s. It must have frames.
MotionState StateAtBegin(const Tracklet& tracklet);
MotionState StateAtEnd(const Tracklet& tracklet);

// People keep their velocity for about a second: an Ornstein-Uhlenbeck process
// of the velocity in each axis. What it expects across a gap, with the
// covariance of position and velocity, is weighed against somebody who may be
// anywhere in `volume_m3`. Nobody's way is known for sure: with the gap grows
// the share of people who come back from elsewhere.
class IdentityMotion {
 public:
  explicit IdentityMotion(double volume_m3) : volume_m3_(volume_m3) {}

  // Log likelihood ratio [nats] of `to` for the one who was in `from` and for
  // somebody else. A `to` that is not later counts as `frame_s` later.
  double LogRatio(const MotionState& from, const MotionState& to,
                  double frame_s) const;

 private:
  double volume_m3_;
};

// The box around everybody's centres and half a metre more [m^3].
double VolumeOf(const std::vector<Tracklet>& tracklets);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IDENTITY_MOTION_H_
