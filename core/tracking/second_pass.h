// Offline: a recording associated again with tracks that were smoothed over all
// of it, and estimated anew.
#ifndef KINEGRAPH_CORE_TRACKING_SECOND_PASS_H_
#define KINEGRAPH_CORE_TRACKING_SECOND_PASS_H_

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <set>
#include <vector>

#include "core/association/affinity.h"
#include "core/base/time.h"
#include "core/data/detection.h"
#include "core/data/pose.h"
#include "core/geometry/epipolar.h"
#include "core/tracking/estimator.h"
#include "core/tracking/evidence.h"
#include "core/tracking/frame_observations.h"
#include "core/tracking/options.h"
#include "core/tracking/packed_queue.h"

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

// The first pass associates with what it knows of the past; the smoothed tracks
// know the frame itself and what follows. Each frame's detections are matched
// with the poses of that very frame, by the affinity of a pose one frame old.
// People, their identities and the frames in which they are written stay those
// of the first pass; what belongs to them may change. Asked to, it follows
// people beyond both ends of their tracks.
class SecondPass {
 public:
  // As Tracker's; `estimator` makes the one that is written.
  SecondPass(SceneModel scene, const Skeleton& detection_skeleton,
             const TrackerOptions& options, EstimatorFactory estimator);

  // Follows people beyond the ends of their runs in `first_pass`, which are all
  // frames of it, but for those named in `but`: with the detections that nobody
  // took, while two views or more agree. Frames in between that fewer saw are
  // written too, and at the very end those that one view saw, as long as the
  // estimate is sure of them. Ends where nothing agrees for the life of a lost
  // track, and where somebody else stands. Before the first frame.
  void ExtendEnds(const std::vector<TrackFrame>& first_pass,
                  const std::set<TrackId>& but);

  // The next frame in ascending order, and what the first pass wrote for it
  // (frames without people may be left out).
  void Process(const DetectionFrame& frame, TrackFrame first_pass);
  // Estimates everyone, on up to `threads` threads, and gives every frame.
  // Nobody is lost: where the estimate has no joint, the first pass's stays.
  std::vector<TrackFrame> Finish(int threads);

 private:
  // A frame that may be looked at once more, from later ends.
  struct Recent {
    DetectionFrame detections;
    size_t index = 0;                      // in frames_
    std::vector<std::vector<char>> taken;  // [view][observation]
  };
  struct Place {  // of an observation in its frame
    size_t view = 0;
    size_t index = 0;
  };
  struct Following {
    EndFollower follower;
    int end = 0;  // counts ends
  };
  enum class Seen { kByNobody, kByOne, kByTwo };  // views that agree, or more
  // A frame beyond an end that was given to an estimator.
  struct Beyond {
    int64_t frame = 0;
    Seen seen = Seen::kByNobody;
    int end = 0;  // counts ends
    bool backward = false;
  };

  // Gives used_views_ to the estimator of a person.
  void AddFrame(int64_t frame, TimeNs time, TrackId id, const Pose3d& start);
  // The one of the person that begins or ends, as `end` says, in the frame.
  const TrackRun* FindRun(TrackId id, int64_t TrackRun::*end,
                          int64_t frame) const;
  // Looks for somebody among what nobody took, fills used_views_ with their
  // places; evidence_ then knows on what they agree.
  Seen Look(const Pose3d& expected, const Recent& recent,
            const FrameObservations& observations);
  void Take(Recent* recent) const;  // used_places_
  void ExtendBack(const PersonPose& person, TimeNs time, const TrackRun& run);
  void ExtendOn(Recent* now);
  void Remember(Recent now);
  void PackBefore(size_t end);  // index in frames_
  // Whether each frame beyond an end is written.
  std::map<int64_t, bool> KeptBeyond(
      const std::vector<Beyond>& beyond,
      const std::vector<FinalPose>& finals) const;
  void WritePerson(TrackId id, std::vector<FinalPose> finals);

  SceneModel scene_;
  TrackerOptions options_;
  EstimatorFactory make_estimator_;
  EpipolarGeometry epipolar_;
  FrameObservations observations_;
  ViewMatcher matcher_;
  EvidenceStep evidence_;
  TimeNs max_lost_;  // of a track

  std::vector<TrackFrame> frames_;  // with the first pass's people
  // Before this frame their poses are packed, [person][frame of theirs]: they
  // are where the second pass finds nobody, and seldom.
  size_t packed_end_ = 0;
  std::map<TrackId, PackedPoses> packed_;
  std::map<TrackId, std::vector<TrackRun>> runs_;  // whose ends are extended
  std::map<TrackId, Following> followers_;         // beyond the last frame
  std::map<TrackId, std::vector<Beyond>> beyond_;
  int ends_ = 0;
  std::deque<Recent> recent_;
  std::map<TrackId, std::unique_ptr<Estimator>> estimators_;

  // This frame's work, kept to reuse its memory.
  std::vector<AssociationTarget> targets_;
  std::vector<std::vector<int>> matches_;  // [view][target]
  FrameObservations earlier_;
  std::vector<Observation> free_;  // that nobody took
  std::vector<UsedView> used_views_;
  std::vector<Place> used_places_;
  EstimatorFrame work_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_TRACKING_SECOND_PASS_H_
