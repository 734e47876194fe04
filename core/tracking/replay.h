// The frozen matches of a tracking run: the 2D detections of each person, frame
// by frame. A replay passes them through joints filter, DLT and any estimator,
// optionally without one of the cameras, but does not associate again, so that
// all smoothing strategies are compared on the same input.
#ifndef KINEGRAPH_CORE_TRACKING_REPLAY_H_
#define KINEGRAPH_CORE_TRACKING_REPLAY_H_

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "core/base/ids.h"
#include "core/base/time.h"
#include "core/data/detection.h"
#include "core/data/observation.h"
#include "core/data/pose.h"
#include "core/geometry/epipolar.h"
#include "core/tracking/estimator.h"
#include "core/tracking/options.h"

namespace kinegraph {

// A detection matched with a person.
struct FrozenDetection {
  int view_idx = 0;       // of the run's cameras
  int detection_idx = 0;  // Detection::index_in_file
};

struct FrozenFrame {
  int64_t frame = 0;
  TimeNs time = 0;
  // In the order in which the views joined the track; may be empty.
  std::vector<FrozenDetection> detections;
  bool written = false;  // the run wrote the person in this frame
};

// All frames from birth to death, tentative ones included.
struct FrozenPerson {
  TrackId id;
  std::vector<FrozenFrame> frames;
};

struct FrozenMatches {
  std::vector<FrozenPerson> people;  // by ascending id
};

// Records the matches of a Tracker at the estimator whose poses are written.
//
//   MatchFreezer freezer;
//   Tracker tracker(scene, skeleton, options, freezer.Wrap(factory));
//   ...  tracker.Finish(&frames);
//   FrozenMatches matches = freezer.Matches(frames);
class MatchFreezer {
 public:
  // A factory whose estimators forward to those of `estimator`. The tracker
  // numbers people in the order in which their estimators are made.
  EstimatorFactory Wrap(EstimatorFactory estimator);

  // All people so far. `tracks` are the frames that the tracker returned,
  // ascending: each person is written in those that contain it.
  FrozenMatches Matches(const std::vector<TrackFrame>& tracks) const;

  using Record = std::vector<FrozenFrame>;  // of one person

 private:
  std::shared_ptr<std::vector<std::shared_ptr<Record>>> records_ =
      std::make_shared<std::vector<std::shared_ptr<Record>>>();
};

// The input of one person's estimator.
struct ReplayedPerson {
  TrackId id;
  // Starts with the first frame in which enough joints could be triangulated.
  std::vector<EstimatorFrame> frames;
  std::vector<char> written;  // one per frame
};

// The output of an estimator.
struct ReplayOutcome {
  std::vector<FinalPose> finals;  // one per frame of the person
  int64_t cpu_ns = 0;             // processor time of the estimator
  // The longest time from a frame until its pose became final, over the poses
  // that became final before Finish(); nullopt if there are none (the estimator
  // needs the whole recording, or the person's frames end within its delay).
  std::optional<TimeNs> delay;
};

// Frozen matches together with their detections.
class Replay {
 public:
  // Throws OptionError unless `detections` has one view per camera of `scene`,
  // InputError for a frame or a detection of the matches that is not among
  // them. `feedback` is the run's causal estimator: its prediction is the input
  // of the joints filter, as in the run. With another kind of estimator the
  // filter's verdicts may differ from the run's.
  Replay(SceneModel scene, const DetectionSequence& detections,
         const FrozenMatches& matches, const TrackerOptions& options,
         EstimatorFactory feedback);

  // Joints filter and DLT for every person, without the camera of view
  // `without_view` (-1: with all cameras). A person starts with the first frame
  // in which the remaining views triangulate as many joints as a new person
  // must have. People without such a frame are left out.
  std::vector<ReplayedPerson> Prepare(int without_view, int threads) const;

  const SceneModel& scene() const { return scene_; }
  const FrozenMatches& matches() const { return matches_; }
  // All frames of the recording, without people.
  const std::vector<TrackFrame>& empty_frames() const { return frames_; }

 private:
  ReplayedPerson PreparePerson(size_t person_idx, int without_view) const;

  SceneModel scene_;
  FrozenMatches matches_;
  TrackerOptions options_;
  EstimatorFactory make_feedback_;
  EpipolarGeometry epipolar_;
  // [person][frame], as FrozenFrame::detections.
  std::vector<std::vector<std::vector<Observation>>> seen_;
  std::vector<TrackFrame> frames_;  // numbers and times
};

// Runs an estimator over one person.
ReplayOutcome RunEstimator(const SceneModel& scene,
                           const ReplayedPerson& person,
                           const EstimatorFactory& estimator);

// Runs an estimator over each person, frame by frame over all people as a
// tracker does, so that data shared between estimators are the same. One
// outcome per person.
std::vector<ReplayOutcome> RunEstimators(
    const SceneModel& scene, const std::vector<ReplayedPerson>& people,
    const EstimatorFactory& estimator);

// Combines the outcomes of all people, which it moves from: each frame from
// `first_frame` on receives the people who are written in it and have a pose.
// `frames` gives numbers and times, ascending.
std::vector<TrackFrame> AssembleReplay(
    const std::vector<TrackFrame>& frames,
    const std::vector<ReplayedPerson>& people,
    std::vector<ReplayOutcome> outcomes,
    int64_t first_frame = std::numeric_limits<int64_t>::min());

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_TRACKING_REPLAY_H_
