// Pieces of tracks, the unit of identity decisions. Tracks are cut at contacts:
// where they come close to each other, another begins or ends close to them, or
// no view sees them for a while, so that the tracker may have continued with
// the wrong person.
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

// One person in one frame. Points into the frames it was created from.
struct TrackletFrame {
  int64_t frame = 0;
  TimeNs time = 0;
  const PersonPose* pose = nullptr;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();  // of the trunk, world
  // From right to left, mean of shoulders and hips; zero: unknown.
  Eigen::Vector3d across_m = Eigen::Vector3d::Zero();
};

struct Tracklet {
  TrackId id;
  std::vector<TrackletFrame> frames;  // ascending
  std::vector<int> body_joints;       // shoulders to wrists, hips to ankles
  // Number of frames at the beginning and the end that are ignored, because
  // they belong to a contact.
  size_t dirty_begin = 0;
  size_t dirty_end = 0;

  const TrackletFrame& first() const { return frames.front(); }
  const TrackletFrame& last() const { return frames.back(); }
  // Indices of the clean frames; of all if none are clean.
  size_t clean_begin() const { return HasClean() ? dirty_begin : 0; }
  size_t clean_end() const {
    return HasClean() ? frames.size() - dirty_end : frames.size();
  }

 private:
  bool HasClean() const { return dirty_begin + dirty_end < frames.size(); }
};

// One tracklet per person, by ascending identity, of the frames in which the
// person has a centre: the mean of hips and shoulders or, without them, of all
// joints.
std::vector<Tracklet> CollectTracklets(const std::vector<TrackFrame>& frames,
                                       const Skeleton& skeleton);

// For two tracks: number of frames in which both are present, and of those in
// which their joints coincide, i.e. are within 0.35 m on average.
struct Together {
  int64_t frames = 0;
  int64_t same_place = 0;
  double distance_m = 0.0;  // mean over the coinciding frames

  // Whether they coincide in nearly all of `frame_count` frames.
  bool OfNearlyAll(size_t frame_count) const {
    return ShareOf(frame_count) >= 0.8;
  }
  double ShareOf(size_t frame_count) const {
    return static_cast<double>(same_place) / static_cast<double>(frame_count);
  }
};
Together Compare(const Tracklet& a, const Tracklet& b);

// Standard deviation of the position of a MotionState on each axis: the trunk's
// centre sways about a straight walk, and is least accurate just where a person
// is lost.
inline constexpr double kStateSigmaM = 0.08;

// Shoulders to wrists and hips to ankles relative to the trunk's centre, in
// world axes [m]; NaN where a joint has no position. Empty: unknown.
struct LimbPosture {
  std::vector<Eigen::Vector3d> limbs_m;
  Eigen::Vector3d across_m = Eigen::Vector3d::Zero();
};

LimbPosture PostureOf(const Tracklet& tracklet, size_t frame_idx);

struct MotionState {
  TimeNs time = 0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  // of the trunk, world
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
  // Mean of TrackletFrame::across_m over the fitted frames; zero: unknown.
  Eigen::Vector3d across_m = Eigen::Vector3d::Zero();
  LimbPosture posture = {};  // in the outermost frame
};

// The state at the beginning and end of a tracklet's clean frames: a line
// fitted to the outermost 0.3 s. The tracklet must have frames.
MotionState StateAtBegin(const Tracklet& tracklet);
MotionState StateAtEnd(const Tracklet& tracklet);
// The state at the last frame not later than `time`; the tracklet must have
// begun by then.
MotionState StateUpTo(const Tracklet& tracklet, TimeNs time);

struct Pieces {
  std::vector<Tracklet> tracklets;  // by ascending identity, then time
  // The piece with which the tracker continued, or -1.
  std::vector<int> next;
  // Whether the piece ends in a cut that was made only because no view saw the
  // person for a while.
  std::vector<char> blind;
  // For a piece that ends in a contact that is not blind: the states before and
  // after each run of frames of the contact in which no view saw the person.
  using Hop = std::pair<MotionState, MotionState>;
  std::vector<std::vector<Hop>> hops;
};

// Cuts tracks at their contacts. A contact's frames are dirty on both sides of
// the cut. Within a second of an end of the track (0.4 s if the track was lost
// from view and recovered elsewhere) a contact makes frames dirty, but cuts
// nothing; a contact so close to both ends is ignored.
Pieces CutAtContacts(const std::vector<Tracklet>& tracks);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IDENTITY_TRACKLET_H_
