// Beyond the ends of a track: where somebody is expected who is not tracked any
// more, or not yet.
#ifndef KINEGRAPH_CORE_TRACKING_TRACK_ENDS_H_
#define KINEGRAPH_CORE_TRACKING_TRACK_ENDS_H_

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <vector>

#include "core/base/time.h"
#include "core/data/pose.h"

namespace kinegraph {

// Frames that follow each other, in all of which a person is there; how they
// move at both ends.
struct TrackRun {
  int64_t first = 0;
  int64_t last = 0;
  Eigen::Vector3d first_velocity_mps = Eigen::Vector3d::Zero();
  Eigen::Vector3d last_velocity_mps = Eigen::Vector3d::Zero();
};

// Of each person, ascending. `frames` ascend.
std::map<TrackId, std::vector<TrackRun>> FindRuns(
    const std::vector<TrackFrame>& frames);

// Somebody who is followed beyond an end, forward or backward in time.
class EndFollower {
 public:
  EndFollower(Pose3d pose, TimeNs time, Eigen::Vector3d velocity_mps);

  // The whole body moved on; the velocity fades within half a second.
  Pose3d At(TimeNs time) const;
  // Views agreed on this pose.
  void Agree(const Pose3d& pose, TimeNs time);
  // When they last did, or the end of the track.
  TimeNs agreed() const { return time_; }

 private:
  Pose3d pose_;
  TimeNs time_;
  Eigen::Vector3d velocity_mps_;
};

// Whether the joints of the two are nearer than `within_m` on average, so that
// one would be the other's double.
bool AtOnePlace(const Pose3d& a, const Pose3d& b, double within_m);
// Whether most of the joints that both have seen (kObserved), three or more,
// are nearer than that. Where the others are is a prediction's word, and of two
// views one joint may be triangulated metres off.
bool SeenAtOnePlace(const Pose3d& a, const Pose3d& b, double within_m);

// Whether somebody of `people` stands where `pose` is: 0.3 m, which is nearer
// than two people ever are for long.
bool IsTaken(const Pose3d& pose, const std::vector<PersonPose>& people);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_TRACKING_TRACK_ENDS_H_
