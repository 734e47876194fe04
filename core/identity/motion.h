// Motion as evidence: how likely a person gets from one state to another in the
// time between them.
#ifndef KINEGRAPH_CORE_IDENTITY_MOTION_H_
#define KINEGRAPH_CORE_IDENTITY_MOTION_H_

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "core/identity/posture.h"
#include "core/identity/tracklet.h"

namespace kinegraph {

struct MotionState {
  TimeNs time = 0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  // of the trunk, world
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
  // From right to left, which turns as the person does; zero: not known.
  Eigen::Vector3d across_m = Eigen::Vector3d::Zero();
  LimbPosture posture = {};  // in the outermost frame
};

// Where a tracklet's clean frames begin and end: a line through the outermost
// 0.3 s. It must have frames.
MotionState StateAtBegin(const Tracklet& tracklet);
MotionState StateAtEnd(const Tracklet& tracklet);
// The same at the last of all frames not later than `time`; the tracklet must
// have begun by then.
MotionState StateUpTo(const Tracklet& tracklet, TimeNs time);

// Where people are in a recording, on the plane in which they spread most: the
// floor.
class UsedSpace {
 public:
  explicit UsedSpace(const std::vector<Tracklet>& tracklets);
  // A rectangle of x and y; the whole of it is its border.
  UsedSpace(const Eigen::Vector2d& low_m, const Eigen::Vector2d& high_m);

  // The rectangle around the centres of all people and half a metre more, in
  // coordinates of the floor.
  const Eigen::Vector2d& low_m() const { return low_m_; }
  const Eigen::Vector2d& high_m() const { return high_m_; }
  double area_m2() const { return (high_m_ - low_m_).prod(); }
  Eigen::Vector2d OnFloor(const Eigen::Vector3d& position_m) const;
  Eigen::Vector2d AlongFloor(const Eigen::Vector3d& direction) const;
  // A unit vector across the floor, up or down.
  Eigen::Vector3d Up() const;

  // How far inside the convex hull of all centres [m]; negative outside, 0 for
  // a rectangle.
  double DepthM(const Eigen::Vector3d& position_m) const;
  // Log density of coming and going at a position against a uniform one [nats]:
  // people come and go at the border of the space. Its mean over the space is
  // 0.
  double LogEntry(const Eigen::Vector3d& position_m) const;

 private:
  double DepthOnFloor(const Eigen::Vector2d& at_m) const;
  // log of the mean over the hull.
  double LogMeanEntry() const;

  Eigen::Vector2d low_m_, high_m_;
  double log_mean_entry_ = 0.0;
  Eigen::Vector3d origin_m_ = Eigen::Vector3d::Zero();
  Eigen::Matrix<double, 2, 3> floor_ = Eigen::Matrix<double, 2, 3>::Zero();
  std::vector<Eigen::Vector2d> hull_m_;  // counterclockwise
};

// Motion across a gap: an Ornstein-Uhlenbeck process of the velocity (time
// constant one second) on each axis of the floor, within the space that is
// used. Its scale depends on the activity (stand, shuffle, stroll, stride),
// which the velocity before the gap tells and which lasts for some seconds. The
// predicted position and velocity, with covariance, are weighed against the
// alternative that one person left and another came, at the border rather than
// in the middle. A standing person mostly keeps facing the same way. With the
// gap grows the share of people who left and came back.
class IdentityMotion {
 public:
  // `entries_at_border`: false where entries are known otherwise.
  // How alike people hold themselves is learnt from `tracklets`.
  IdentityMotion(UsedSpace space, bool entries_at_border,
                 const std::vector<Tracklet>& tracklets = {})
      : space_(std::move(space)),
        entries_at_border_(entries_at_border),
        postures_(tracklets, space_.Up()) {}

  // Log likelihood ratio [nats] of the state `to` for the same person as in
  // `from` and for another. A `to` that is not later counts as `frame_s` later.
  double LogRatio(const MotionState& from, const MotionState& to,
                  double frame_s) const;

 private:
  // Log likelihood ratio [nats] of the heading in `to` for the same person as
  // in `from` and for another.
  double LogTurn(const MotionState& from, const MotionState& to,
                 double gap_s) const;

  UsedSpace space_;
  bool entries_at_border_;
  PostureModel postures_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IDENTITY_MOTION_H_
