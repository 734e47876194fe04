// Pieces of tracks: what identities are decided on.
#ifndef KINEGRAPH_CORE_IDENTITY_TRACKLET_H_
#define KINEGRAPH_CORE_IDENTITY_TRACKLET_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/base/ids.h"
#include "core/base/time.h"
#include "core/data/pose.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph {

// One person in one frame. Points into the frames it was made from.
struct TrackletFrame {
  int64_t frame = 0;
  TimeNs time = 0;
  const PersonPose* pose = nullptr;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();  // of the trunk, world
  // From right to left, shoulders and hips on average; zero: not known.
  Eigen::Vector3d across_m = Eigen::Vector3d::Zero();
};

struct Tracklet {
  TrackId id;
  std::vector<TrackletFrame> frames;  // ascending
  std::vector<int> body_joints;       // shoulders to wrists, hips to ankles
  // Frames at the beginning and at the end that are no evidence, as another
  // person was too near.
  size_t dirty_begin = 0;
  size_t dirty_end = 0;

  const TrackletFrame& first() const { return frames.front(); }
  const TrackletFrame& last() const { return frames.back(); }
  // Indices of the clean frames; all when none are clean.
  size_t clean_begin() const { return HasClean() ? dirty_begin : 0; }
  size_t clean_end() const {
    return HasClean() ? frames.size() - dirty_end : frames.size();
  }

 private:
  bool HasClean() const { return dirty_begin + dirty_end < frames.size(); }
};

// Everybody's frames with a centre, by ascending identity. Hips and shoulders
// make the centre, or, without them, all joints.
std::vector<Tracklet> CollectTracklets(const std::vector<TrackFrame>& frames,
                                       const Skeleton& skeleton);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IDENTITY_TRACKLET_H_
