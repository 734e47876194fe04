// The matches of a tracking run, frozen: whose 2D detections were whose, frame
// by frame. Replayed, they go through joints filter, DLT and any estimator
// again, also without one of the cameras, and nothing is associated anew. So
// every smoothing strategy answers to the same question.
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

// A detection that belongs to a person.
struct FrozenDetection {
  int view_idx = 0;       // of the run's cameras
  int detection_idx = 0;  // index_in_file
};

struct FrozenFrame {
  int64_t frame = 0;
  TimeNs time = 0;
  // In the order in which the views joined the track; may be empty.
  std::vector<FrozenDetection> detections;
  bool written = false;  // by the rules of track life
};

// A life from birth to the last frame, tentative frames included.
struct FrozenPerson {
  TrackId id;
  std::vector<FrozenFrame> frames;
};

struct FrozenMatches {
  std::vector<FrozenPerson> people;  // by ascending id
};

// Listens to a Tracker at the estimator that is written.
//
//   MatchFreezer freezer;
//   Tracker tracker(scene, skeleton, options, freezer.Wrap(factory));
//   ...  tracker.Finish(&frames);
//   FrozenMatches matches = freezer.Matches(options.life, frame_rate_hz);
class MatchFreezer {
 public:
  // A factory of estimators that do what those of `estimator` do. The tracker
  // numbers people in the order in which they are made.
  EstimatorFactory Wrap(EstimatorFactory estimator);

  // All people so far. Which frames are written follows from their hits and
  // misses by the rules of track life.
  FrozenMatches Matches(const TrackLifeOptions& life,
                        double frame_rate_hz) const;

  struct Record;  // one person's

 private:
  std::shared_ptr<std::vector<std::shared_ptr<Record>>> records_ =
      std::make_shared<std::vector<std::shared_ptr<Record>>>();
};

// What estimators are given of one person.
struct ReplayedPerson {
  TrackId id;
  // From the first frame on in which enough joints could be triangulated.
  // Points into the Replay.
  std::vector<EstimatorFrame> frames;
  std::vector<char> written;  // one a frame
};

// An estimator's answer.
struct ReplayOutcome {
  std::vector<FinalPose> finals;  // one a frame of the person
  int64_t cpu_ns = 0;             // processor time of the estimator
  // How long after its frame the latest pose became final before the end of the
  // recording; nullopt when none did (the estimator wants the whole recording).
  std::optional<TimeNs> delay;
};

// Frozen matches with their detections at hand.
class Replay {
 public:
  // `detections` has one view for each camera of `scene` and every frame that
  // the matches name, else InputError. `feedback` is the run's causal
  // estimator: its prediction serves the joints filter, as in the run. With a
  // feedback of another kind than the run's the verdicts may differ.
  Replay(SceneModel scene, const DetectionSequence& detections,
         const FrozenMatches& matches, const TrackerOptions& options,
         EstimatorFactory feedback);

  // Joints filter and DLT of everyone, as if the camera of view `without_view`
  // had not been there (-1: with all). A person begins with the first frame in
  // which the rest of the views triangulate as many joints as a new person must
  // have. People without such a frame are left out.
  std::vector<ReplayedPerson> Prepare(int without_view, int threads) const;

  const SceneModel& scene() const { return scene_; }
  const FrozenMatches& matches() const { return matches_; }
  // All frames of the recording.
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

// Runs an estimator over each person, all frames of the recording in order, as
// a tracker does: what people learn of each other is the same. One outcome
// each.
std::vector<ReplayOutcome> RunEstimators(
    const SceneModel& scene, const std::vector<ReplayedPerson>& people,
    const EstimatorFactory& estimator);

// Puts the outcomes of all people, which it moves, together: in each frame from
// `first_frame` on the people who are written and have a pose. `frames` gives
// numbers and times, ascending.
std::vector<TrackFrame> AssembleReplay(
    const std::vector<TrackFrame>& frames,
    const std::vector<ReplayedPerson>& people,
    std::vector<ReplayOutcome> outcomes,
    int64_t first_frame = std::numeric_limits<int64_t>::min());

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_TRACKING_REPLAY_H_
