// Offline: associates a recording again, with the tracks smoothed over all of
// it, and estimates again.
#ifndef KINEGRAPH_CORE_TRACKING_SECOND_PASS_H_
#define KINEGRAPH_CORE_TRACKING_SECOND_PASS_H_

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "core/association/affinity.h"
#include "core/association/all_view_matching.h"
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

// Consecutive frames that all contain a person, and the velocity of the mean of
// the joints at both ends.
struct TrackRun {
  int64_t first = 0;
  int64_t last = 0;
  Eigen::Vector3d first_velocity_mps = Eigen::Vector3d::Zero();
  Eigen::Vector3d last_velocity_mps = Eigen::Vector3d::Zero();
};

// Runs of each person in ascending order. `frames` ascend.
std::map<TrackId, std::vector<TrackRun>> FindRuns(
    const std::vector<TrackFrame>& frames);

// Follows a person beyond an end of a track, forward or backward in time.
class EndFollower {
 public:
  EndFollower(Pose3d pose, TimeNs time, Eigen::Vector3d velocity_mps);

  // The body translated from the last pose; the velocity decays with a time
  // constant of half a second.
  Pose3d At(TimeNs time) const;
  // To be called when views agreed on this pose.
  void Agree(const Pose3d& pose, TimeNs time);
  // Time of the last agreement, or the end of the track.
  TimeNs agreed() const { return time_; }

 private:
  Pose3d pose_;
  TimeNs time_;
  Eigen::Vector3d velocity_mps_;
};

// The first pass associates with poses predicted from the past; smoothed tracks
// also use the frame itself and later ones. The detections of each frame are
// matched with the poses of that same frame, with the affinity of a pose one
// frame old. People, their identities and the frames in which they are written
// stay those of the first pass; the detections matched with them may change.
// Optionally follows people beyond both ends of their tracks.
class SecondPass {
 public:
  // Takes the arguments of Tracker's constructor, but a single estimator, whose
  // poses are written.
  SecondPass(SceneModel scene, const Skeleton& detection_skeleton,
             const TrackerOptions& options, EstimatorFactory estimator);

  // Call before the first frame. Follows people, except those in `but`, beyond
  // the ends of their runs in `first_pass` (all its frames), using unmatched
  // detections while two or more views agree. Frames with fewer views are also
  // written if they lie in between, or if they are at the very end, one view
  // sees the person and the estimate is sufficiently certain. Stops when no
  // views have agreed for the age limit of a lost track, where another person
  // stands and, backward, 2 s before the run.
  void ExtendEnds(const std::vector<TrackFrame>& first_pass,
                  const std::set<TrackId>& but);

  // The next frame, in ascending order, and the first pass's result for it
  // (frames without people may be omitted).
  void Process(const DetectionFrame& frame, TrackFrame first_pass);
  // Estimates all people, on up to `threads` threads, and returns every frame.
  // No person is dropped: a joint without an estimate is taken from the first
  // pass, and becomes inferred if other joints have an estimate.
  std::vector<TrackFrame> Finish(int threads);

 private:
  // A frame kept because a later track start may be followed back into it.
  struct Recent {
    DetectionFrame detections;
    size_t index = 0;                      // in frames_
    std::vector<std::vector<char>> taken;  // [view][observation]
  };
  struct Place {  // an observation within its frame
    size_t view = 0;
    size_t index = 0;
  };
  struct Following {
    EndFollower follower;
    int end = 0;  // number of the extension
  };
  // kInNoView: no view is matched with the person; kInOneView: one is, or
  // several that do not agree; kInTwoViews: two or more that agree.
  enum class Seen { kInNoView, kInOneView, kInTwoViews };
  // A frame beyond an end that was given to an estimator.
  struct Beyond {
    int64_t frame = 0;
    Seen seen = Seen::kInNoView;
    int end = 0;  // number of the extension
    bool backward = false;
  };

  // [view][target]: index of the matched observation in `views[view]`, or -1.
  // `age_s` is the time from the targets' poses to this frame.
  void MatchViews(const std::vector<AssociationTarget>& targets, double age_s,
                  const std::vector<Span<Observation>>& views,
                  std::vector<std::vector<int>>* matches);
  // Passes used_views_ to the estimator of a person.
  void AddFrame(int64_t frame, TimeNs time, TrackId id, const Pose3d& start);
  // The run of the person whose first or last frame, selected by `end`, is
  // `frame`; nullptr if there is none.
  const TrackRun* FindRun(TrackId id, int64_t TrackRun::*end,
                          int64_t frame) const;
  // Matches the unmatched detections with a person, whose expected pose is
  // predicted over `age_s`, and stores the matches in used_views_ and
  // used_places_; evidence_ then holds the joints on which they agree.
  Seen MatchUnmatched(const Pose3d& expected, double age_s,
                      const Recent& recent,
                      const FrameObservations& observations);
  void Take(Recent* recent) const;  // marks used_places_
  // Follows a person from the first frame of `run`, at `time`, backward through
  // recent_.
  void ExtendBack(const PersonPose& person, TimeNs time, const TrackRun& run);
  // Follows the people in followers_ into the current frame.
  void ExtendOn(Recent* now);
  void Remember(Recent now);
  // Moves the poses of the frames before this index in frames_ to packed_.
  void PackBefore(size_t end);
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
  // For skeletons of few joints: instead of matcher_.
  std::optional<AllViewMatcher> all_views_;
  EvidenceStep evidence_;
  TimeNs max_lost_;  // life of a lost track

  std::vector<TrackFrame> frames_;  // hold the first pass's people
  // Poses before this frame are packed, [person][its frames]: they are needed
  // only for joints that the second pass does not estimate, which are few.
  size_t packed_end_ = 0;
  std::map<TrackId, PackedPoses> packed_;
  std::map<TrackId, std::vector<TrackRun>> runs_;  // with ends to be extended
  std::map<TrackId, Following> followers_;         // beyond the last frame
  std::map<TrackId, std::vector<Beyond>> beyond_;
  int ends_ = 0;  // number of extensions so far
  std::deque<Recent> recent_;
  std::map<TrackId, std::unique_ptr<Estimator>> estimators_;

  // Buffers of the current frame, kept to reuse their memory.
  std::vector<AssociationTarget> targets_;
  std::vector<std::vector<int>> matches_;  // [view][target]
  FrameObservations earlier_;
  std::vector<Observation> free_;  // unmatched
  std::vector<UsedView> used_views_;
  std::vector<Place> used_places_;
  EstimatorFrame work_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_TRACKING_SECOND_PASS_H_
