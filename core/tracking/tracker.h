// The front end of Chu et al. (2021; "the paper"): runs the stages of a frame
// in order: 2D-3D association view by view (Eq. 1), joints filter and DLT for
// each track (Eq. 2 and 3), new people from the unmatched detections (Algorithm
// 2). Their mathematics is in other files. Graph mode adds a policy to
// association (association_policy.h) and, for skeletons of few joints, matches
// all views at once (all_view_matching.h).
#ifndef KINEGRAPH_CORE_TRACKING_TRACKER_H_
#define KINEGRAPH_CORE_TRACKING_TRACKER_H_

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "core/association/affinity.h"
#include "core/association/all_view_matching.h"
#include "core/base/ids.h"
#include "core/data/detection.h"
#include "core/data/pose.h"
#include "core/reconstruction/initialisation.h"
#include "core/tracking/association_policy.h"
#include "core/tracking/estimator.h"
#include "core/tracking/evidence.h"
#include "core/tracking/frame_observations.h"
#include "core/tracking/options.h"
#include "core/tracking/track.h"

namespace kinegraph {

// Releases a frame once every track alive in it has resolved it. Tracks resolve
// each frame of their life once, in ascending order.
class FrameAssembler {
 public:
  // The next frame, ascending. People alive in it follow by Join.
  void BeginFrame(int64_t frame, TimeNs time);
  // The newest frame waits for one more track.
  void Join() { ++open_.back().waiting; }
  // A track's result for a frame; `person` is null when it is not written.
  void Resolve(int64_t frame, PersonPose* person);

  // Moves out the frames that are complete, people by ascending id.
  void ExtractComplete(std::vector<TrackFrame>* frames);

 private:
  struct OpenFrame {
    TrackFrame content;
    int waiting = 0;
  };
  std::deque<OpenFrame> open_;
};

// Processor time that the calling thread spent in each stage [ns], summed over
// frames. The paper's runtime table has association, reconstruction and
// initialisation.
struct StageTimes {
  int64_t preparation_ns = 0;     // skeleton conversion, undistortion
  int64_t association_ns = 0;     // projection, affinity, assignment
  int64_t reconstruction_ns = 0;  // joints filter, DLT
  int64_t estimation_ns = 0;      // smoothing, motion model
  int64_t initialisation_ns = 0;
  int64_t output_ns = 0;
};

class Tracker {
 public:
  // `detection_skeleton` is the skeleton of the detections; `scene.cameras` has
  // one camera per view, in the same order. If `output` is empty, the feedback
  // estimator's poses are written. Throws OptionError for options or a frame
  // rate out of range, or a scene without cameras.
  Tracker(SceneModel scene, const Skeleton& detection_skeleton,
          const TrackerOptions& options, EstimatorFactory feedback,
          EstimatorFactory output = nullptr);
  ~Tracker();
  Tracker(const Tracker&) = delete;
  Tracker& operator=(const Tracker&) = delete;

  // The next frame. Frames that became complete are added to `finished`. Throws
  // InputError when frame number or time does not ascend, OptionError unless
  // there is one view per camera.
  void Process(const DetectionFrame& frame, std::vector<TrackFrame>* finished);
  // Ends all tracks: no person continues into the next frame.
  void StartAnew();
  // Ends the recording: all remaining frames become final.
  void Finish(std::vector<TrackFrame>* finished);

  // People currently tracked, tentative ones included.
  size_t track_count() const { return tracks_.size(); }
  int64_t people_so_far() const { return next_id_; }
  // Null (the default) disables the measurement.
  void set_stage_times(StageTimes* times) { stage_times_ = times; }
  // Threads for the estimators; does not affect results.
  void set_threads(int threads) { threads_ = threads; }

 private:
  void CheckFrame(const DetectionFrame& frame) const;
  void ForgetStale(TimeNs time);
  void Associate(const DetectionFrame& frame);
  void SetTargets(const DetectionFrame& frame);
  void SetLastSeen(int view_idx, TimeNs time);
  void MatchView(size_t view_idx, TimeNs time);
  void MatchAllViews(TimeNs time);
  void Assign(size_t view_idx, size_t observation_idx, size_t target,
              TimeNs time);
  void CollectUnmatched();
  void Reconstruct(const DetectionFrame& frame);
  void Estimate();
  void StepLives(TimeNs time, bool is_look);
  void FindNewPeople(const DetectionFrame& frame);
  void FindSlightPeople();
  void Withdraw(size_t target, const DetectionFrame& frame);
  void StartNewPeople(const DetectionFrame& frame);
  void StartTrack(const NewPerson& person, const DetectionFrame& frame);
  enum class Leaving { kEnded, kEverybody };
  void HandOver(Leaving leaving);
  void HandOverFinals(Track* track);

  SceneModel scene_;
  TrackerOptions options_;
  EstimatorFactory make_feedback_;
  EstimatorFactory make_output_;
  FrameClock clock_;
  const bool goes_by_looks_;  // graph mode: an empty frame is a miss only if
                              // the detector ran on it
  LookRhythm rhythm_;
  EpipolarGeometry epipolar_;
  FrameObservations observations_;
  ViewMatcher matcher_;
  // Graph mode, for skeletons of few joints: instead of matcher_.
  std::optional<AllViewMatcher> all_views_;
  EvidenceStep evidence_;
  Initialiser initialiser_;
  Initialiser slight_initialiser_;
  const bool cross_view_;   // the affinity of Chen et al.
  const int memory_depth_;  // poses per view that a track remembers

  std::vector<std::unique_ptr<Track>> tracks_;
  int64_t next_id_ = 0;
  std::optional<int64_t> last_frame_;
  TimeNs last_time_ = 0;  // of last_frame_
  int threads_ = 1;
  StageTimes* stage_times_ = nullptr;
  FrameAssembler assembler_;

  // Buffers of the current frame, kept to reuse their memory.
  std::vector<ObservationGroup> unmatched_;  // [view]
  std::vector<AssociationTarget> targets_;
  std::vector<std::vector<int>> matches_;  // [view][track]
  std::vector<int> view_match_;            // of the current view, [track]
  std::vector<char> forbidden_;            // of the current view,
                                           // [track][observation]
  Pose3d predicted_;
  std::vector<NewPerson> new_people_;
  std::vector<NewPerson> slight_people_;  // with fewer joints than new_people_
  std::vector<FinalPose> finals_;

  const AssociationState state_;  // refers to the members above
  const std::unique_ptr<AssociationPolicy> policy_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_TRACKING_TRACKER_H_
