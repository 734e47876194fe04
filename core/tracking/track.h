// The state of one person in the tracker.
#ifndef KINEGRAPH_CORE_TRACKING_TRACK_H_
#define KINEGRAPH_CORE_TRACKING_TRACK_H_

#include <deque>
#include <memory>
#include <vector>

#include "core/association/affinity.h"
#include "core/base/ids.h"
#include "core/base/time.h"
#include "core/data/detection.h"
#include "core/data/observation.h"
#include "core/tracking/estimator.h"
#include "core/tracking/options.h"

namespace kinegraph {

bool HasDetections(const DetectionFrame& frame);

// A detector may run on every third frame of a video, or a 120 Hz file may hold
// detections made at 30 Hz: the frames in between are empty in every view,
// which must not count as misses. A look is a frame on which the detector ran;
// the intervals between frames with detections distinguish looks without people
// from frames that are no looks.
class LookRhythm {
 public:
  explicit LookRhythm(const FrameClock& clock) : clock_(clock) {}

  // Processes the next frame. Returns whether the detector ran on it: some view
  // has a detection, or none has had one for as long as the longest recent
  // interval between frames with detections (if enough intervals are known).
  bool IsLook(const DetectionFrame& frame);

  // Typical interval between frames with detections [frames], at least 1: the
  // third quartile of the recent intervals.
  double usual_frames() const { return usual_frames_; }
  // The number of frames that the newest frame with detections represents: the
  // frames since the previous one with detections, at most usual_frames().
  double newest_frames() const { return newest_frames_; }

 private:
  void Note(double frames);

  FrameClock clock_;
  bool begun_ = false;
  TimeNs last_ = 0;            // last frame with detections
  std::deque<double> pauses_;  // [frames], the newest last
  double usual_frames_ = 1.0;
  double newest_frames_ = 1.0;
};

// The newest 2D poses of each view, in the order in which views first joined
// the track. A view keeps its position when it is matched again or returns
// after a pause, because the joints filter visits conflicts in this order.
// Poses of one view are adjacent, the newest first.
class ViewMemory {
 public:
  // Keeps up to `depth` poses per view.
  explicit ViewMemory(int depth = 1) : depth_(depth) {}

  struct Entry {
    TimeNs frame_time = 0;
    Observation observation;
  };

  void Store(const Observation& observation, TimeNs frame_time);
  const std::vector<Entry>& entries() const { return entries_; }

 private:
  int depth_;
  std::vector<Entry> entries_;
};

enum class TrackState { kTentative, kConfirmed, kDeleted };

// Track life, after the code of Chu et al. (2021; the paper does not specify
// it): confirmed after a number of hits (updates); a tentative track is deleted
// at its first miss (no view matched), any track when its last update is too
// old. Misses do not reset hits.
// Where the detector does not run on every frame (LookRhythm), a hit counts as
// the frames that it represents; two hits that represent confirm_hits frames
// are then enough.
class TrackLife {
 public:
  // Options in frames (LifeInFrames).
  TrackLife(const TrackLifeOptions& options, const FrameClock& clock,
            TimeNs birth_time);

  // Starts a new frame. A track whose last update is older than its age limit
  // by `look_frames` is deleted before it can match anything: after missing
  // frames its distance gate could cover the whole image. With independent
  // frames every track is deleted. `look_frames`: typical interval between
  // frames on which the detector runs.
  void BeginFrame(TimeNs time, double look_frames = 1.0);

  // A frame on which the detector ran: whether any view matched, and whether
  // the update succeeded. It represents `frames` frames.
  void Step(TimeNs time, bool matched, bool updated, double frames = 1.0);

  // Ends a track that turned out to be false.
  void End() { state_ = TrackState::kDeleted; }

  TrackState state() const { return state_; }
  TimeNs last_update() const { return last_update_; }

 private:
  void ConfirmIfDue();

  int64_t confirm_hits_;
  double max_age_frames_;
  bool independent_frames_;
  FrameClock clock_;
  TrackState state_ = TrackState::kTentative;
  int64_t hits_ = 1;         // birth is the first
  double hit_frames_ = 1.0;  // frames that the hits represent
  TimeNs last_update_;
};

// Decides which frames of a track are written. Tentative frames with an update
// wait for confirmation if TrackLifeOptions::backfill, else they are dropped. A
// gap in a confirmed track waits for the update that closes it and is written
// if it has at most max_gap_frames frames; other frames without an update are
// dropped.
class WriteGate {
 public:
  WriteGate(const TrackLifeOptions& options, const FrameClock& clock)
      : backfill_(options.backfill),
        max_gap_frames_(options.max_gap_frames),
        clock_(clock) {}

  // The next frame, after TrackLife::Step.
  void Step(TimeNs time, TrackState state, bool updated);
  // Ends the track: frames that still wait are dropped.
  void Close();

  // Pops the decision on the oldest frame; false while it is pending.
  bool Pop(bool* write);

 private:
  enum class Verdict { kWrite, kDrop, kTentative, kGap };
  void Settle(Verdict waiting, Verdict verdict);

  bool backfill_;
  double max_gap_frames_;
  FrameClock clock_;
  bool was_confirmed_ = false;
  TimeNs last_update_ = 0;
  std::deque<Verdict> verdicts_;
};

struct Track {
  Track(TrackId track_id, TrackLife track_life, WriteGate write_gate,
        int memory_depth = 1)
      : id(track_id),
        life(track_life),
        gate(std::move(write_gate)),
        memory(memory_depth) {}

  TrackId id;
  TrackLife life;
  WriteGate gate;
  ViewMemory memory;
  std::unique_ptr<Estimator> feedback;  // used for association
  std::unique_ptr<Estimator> output;    // null: the poses of `feedback` are
                                        // written

  Estimator& writer() { return output != nullptr ? *output : *feedback; }

  // Buffers of the current frame, kept to reuse their memory.
  EstimatorFrame frame;
  bool matched = false;
  Pose3d expected;                       // in this frame, for association
  std::vector<LastSeenJoint> last_seen;  // in the current view, for association
  std::deque<FinalPose> finals;  // final poses on which the gate has not
                                 // decided yet
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_TRACKING_TRACK_H_
