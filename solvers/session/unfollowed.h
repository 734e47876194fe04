// Finds people who are visible in a view for a long time but not tracked, for
// example behind a table or at the edge of the volume seen by two views. The
// mean fraction of matched detections does not reveal them.
#ifndef KINEGRAPH_SOLVERS_SESSION_UNFOLLOWED_H_
#define KINEGRAPH_SOLVERS_SESSION_UNFOLLOWED_H_

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/data/detection.h"
#include "core/data/pose.h"
#include "core/geometry/camera.h"

namespace kinegraph {

struct UnfollowedPerson {
  size_t view = 0;
  double share = 0.0;  // of the recording's frames
  int64_t first_frame = 0;
  int64_t last_frame = 0;
};

// Links unmatched detections from frame to frame by their boxes. Memory grows
// only with the number of people in a few frames.
class UnfollowedPeople {
 public:
  // `cameras` must outlive this object. `map`: for each joint of the tracks,
  // the index of the same joint of the detections, or -1. Detections with fewer
  // than `least_joints` found joints are ignored.
  UnfollowedPeople(const CameraRig& cameras, std::vector<int> map,
                   int least_joints);

  // `seen` has the used views; `tracked` the people written in the frame.
  void See(const DetectionFrame& seen, const TrackFrame& tracked);

  // People seen in at least a fifth of the frames and for at least 3 s, the
  // most frequent first.
  std::vector<UnfollowedPerson> Often() const;

 private:
  struct Chain {
    Eigen::AlignedBox2d box;  // when last seen
    // When last seen or, if the clock has stopped or stepped back since, the
    // time of the frame in which it did.
    TimeNs time = 0;
    UnfollowedPerson person;
    int64_t frames = 0;
  };

  // Whether a tracked person is at the position of the detection.
  bool IsFollowed(const Detection& detection, size_t view,
                  const TrackFrame& tracked) const;
  void Continue(const Eigen::AlignedBox2d& box, size_t view,
                const DetectionFrame& seen);
  bool IsLong(const Chain& chain) const;

  const CameraRig& cameras_;
  const std::vector<int> map_;
  const int least_joints_;
  int64_t frames_ = 0;
  double step_s_ = 0.0;  // the longest frame interval below a second
  // Number of frame intervals that are not negative, and their sum.
  int64_t steps_ = 0;
  TimeNs passed_ = 0;
  TimeNs last_time_ = 0;
  int64_t last_frame_ = 0;
  std::vector<Chain> chains_;  // chains that may continue
  std::vector<Chain> ended_;   // ended chains of sufficient length
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SESSION_UNFOLLOWED_H_
