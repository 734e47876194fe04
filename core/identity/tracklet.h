// Pieces of tracks: what identities are decided on. Tracks are cut at contacts:
// where they come so near to one another, or are lost or found so near to
// another, that the tracker may have continued with the wrong person.
#ifndef KINEGRAPH_CORE_IDENTITY_TRACKLET_H_
#define KINEGRAPH_CORE_IDENTITY_TRACKLET_H_

#include <Eigen/Core>
#include <cstdint>
#include <utility>
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

// Of two tracks: frames in which both are there, and in which their joints are
// within 0.35 m on average, at one place.
struct Together {
  int64_t frames = 0;
  int64_t same_place = 0;
  double distance_m = 0.0;  // mean over those at the same place

  // Whether they stand together nearly all of this time.
  bool OfNearlyAll(size_t frame_count) const {
    return ShareOf(frame_count) >= 0.8;
  }
  double ShareOf(size_t frame_count) const {
    return static_cast<double>(same_place) / static_cast<double>(frame_count);
  }
};
Together Compare(const Tracklet& a, const Tracklet& b);

// Standard deviation of the position of a state: the trunk's centre sways about
// a straight walk, and is measured worst just where a person is lost.
inline constexpr double kStateSigmaM = 0.08;

// Shoulders to wrists and hips to ankles from the trunk's centre, in world axes
// [m]; NaN where a joint has no position. Empty: not known.
struct LimbPosture {
  std::vector<Eigen::Vector3d> limbs_m;
  Eigen::Vector3d across_m = Eigen::Vector3d::Zero();
};

LimbPosture PostureOf(const Tracklet& tracklet, size_t frame_idx);

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

struct Pieces {
  std::vector<Tracklet> tracklets;  // by ascending identity, then time
  // The piece with which the tracker went on, or -1.
  std::vector<int> next;
  // Whether it did so blindly: cut because no view saw the person for a while.
  std::vector<char> blind;
  // Within a longer contact at whose cut the tracker continued: the states
  // before and after the frames that no view saw.
  using Hop = std::pair<MotionState, MotionState>;
  std::vector<std::vector<Hop>> hops;
};

// Cuts tracks at their contacts. A contact's frames are dirty on both sides of
// the cut.
Pieces CutAtContacts(const std::vector<Tracklet>& tracks);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IDENTITY_TRACKLET_H_
