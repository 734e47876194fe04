// One person as the tracker follows them.
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

bool ShowsSomebody(const DetectionFrame& frame);

// A detector may run in every third frame of a video, or a file of 120 Hz may
// hold what was detected at 30: frames in between show nobody in any view, and
// nobody is missed there. The times between frames that show somebody tell such
// frames from those in which everybody has gone.
class LookRhythm {
 public:
  explicit LookRhythm(const FrameClock& clock) : clock_(clock) {}

  // The next frame. Whether somebody would have been seen in it: a view shows
  // somebody, or none has for longer than the detector has lately paused.
  bool IsLook(const DetectionFrame& frame);

  // Usual time from one frame that shows somebody to the next [frames], 1 or
  // more: the third quartile of the last ones.
  double usual_frames() const { return usual_frames_; }
  // How many frames the newest one that shows somebody stands for: those since
  // the one before, but no more than usual.
  double newest_frames() const { return newest_frames_; }

 private:
  void Note(double frames);

  FrameClock clock_;
  bool begun_ = false;
  TimeNs last_ = 0;            // frame that showed somebody
  std::deque<double> pauses_;  // [frames], the newest last
  double usual_frames_ = 1.0;
  double newest_frames_ = 1.0;
};

// The newest 2D poses of each view, in the order in which views first joined
// the track. A view keeps its place when it is matched again or back after a
// pause: the joints filter walks conflicts in this order. Poses of one view
// follow each other, the newest first.
class ViewMemory {
 public:
  // Keeps so many poses of each view.
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

// Track life, after the authors' code (the paper is silent): confirmed at a
// number of hits; a tentative track without a match is deleted at once, any
// track when its last update is too old. Misses do not reset hits. Where a
// detector does not look in every frame (LookRhythm), a hit counts as the
// frames that it stands for, and two are enough.
class TrackLife {
 public:
  // Options in frames (LifeInFrames).
  TrackLife(const TrackLifeOptions& options, const FrameClock& clock,
            TimeNs birth_time);

  // A new frame begins. A track whose last update is longer ago than its age
  // allows is deleted before it can match anything: where frames were dropped
  // or cut out, its gate would by now be as wide as the image. Nothing lives on
  // into another of several independent frames. `look_frames`: usual time from
  // one look of the detector to the next.
  void BeginFrame(TimeNs time, double look_frames = 1.0);

  // Tells of a frame in which the detector looked: matched in any view, and
  // whether the update succeeded. The look stands for so many `frames`.
  void Step(TimeNs time, bool matched, bool updated, double frames = 1.0);

  // The track is not what it seemed to be.
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
  double hit_frames_ = 1.0;  // that they stand for
  TimeNs last_update_;
};

// Which frames of a track are written. Tentative frames wait for confirmation
// (or are dropped), gaps wait for the update that closes them.
class WriteGate {
 public:
  WriteGate(const TrackLifeOptions& options, const FrameClock& clock)
      : backfill_(options.backfill),
        max_gap_frames_(options.max_gap_frames),
        clock_(clock) {}

  // Tells of the frame after TrackLife::Step.
  void Step(TimeNs time, TrackState state, bool updated);
  // The track is gone: what still waits is dropped.
  void Close();

  // Takes the verdict on the oldest frame not yet taken. False while it waits.
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
  std::unique_ptr<Estimator> feedback;  // serves association
  std::unique_ptr<Estimator> output;  // null: the feedback's finals are written

  Estimator& writer() { return output != nullptr ? *output : *feedback; }

  // This frame's work, kept to reuse its memory.
  EstimatorFrame frame;
  bool matched = false;
  Pose3d expected;                       // in this frame, for association
  std::vector<LastSeenJoint> last_seen;  // in the view at hand, likewise
  std::deque<FinalPose> finals;  // final, but the gate has not decided yet
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_TRACKING_TRACK_H_
