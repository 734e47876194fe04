// A whole tracking run over detections that can be read from the beginning:
// what every command that tracks calls.
#ifndef KINEGRAPH_SOLVERS_SESSION_RUN_H_
#define KINEGRAPH_SOLVERS_SESSION_RUN_H_

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>

#include "core/io/detections/source.h"
#include "core/tracking/replay.h"
#include "solvers/session/options.h"
#include "solvers/session/scene.h"
#include "solvers/session/session.h"

namespace kinegraph {

// Detections held in memory, as a source that can be read again and again.
class MemorySource final : public DetectionSource {
 public:
  // `sequence` must outlive the source.
  explicit MemorySource(const DetectionSequence& sequence)
      : sequence_(&sequence) {}
  const DetectionHeader& header() const override { return sequence_->header; }
  bool Next(DetectionFrame* frame) override;
  int64_t frame_count() const override {
    return static_cast<int64_t>(sequence_->frames.size());
  }

 private:
  const DetectionSequence* sequence_;
  size_t next_ = 0;
};

// Holds the detections of frames that are not final yet: those that it is fed,
// or, where everything waits for the end of the recording, those of a second
// reading.
class UsedFrames {
 public:
  // Without `reopen` frames come from Feed. `scene` must outlive the object.
  UsedFrames(const RunScene& scene, SourceOpener reopen);
  void Feed(const DetectionFrame& used);
  // Frames are asked for in ascending order; nullptr when it never came.
  const DetectionFrame* At(int64_t frame);

 private:
  const RunScene* scene_;
  SourceOpener reopen_;
  std::unique_ptr<DetectionSource> source_;
  std::deque<DetectionFrame> waiting_;
  DetectionFrame read_;
  DetectionFrame current_;
};

// Feeds `session` all that `source` gives and finishes it; `write` gets each
// finished frame in order.
void TrackAll(DetectionSource* source, Session* session,
              const std::function<void(TrackFrame&&)>& write);

// Detections in memory, tracked, with cameras and clocks refined and the world
// on its floor before, where the options ask for it. `view_bias`, if not null,
// receives what was learnt of the detector's bias; `progress`, if not empty,
// how many frames were read so far.
TrackSequence TrackSequenceOf(
    const RunOptions& options, const RunRequest& request,
    const DetectionSequence& detections, ViewBias* view_bias = nullptr,
    const std::function<void(int64_t)>& progress = nullptr);

// A run whose matches are kept (core/tracking/replay.h).
struct FrozenRun {
  RunScene scene;      // its cameras in the run's metres
  SubjectScale scale;  // of them
  // As the tracker was fed: used views alone, the warm-up before `first_frame`.
  DetectionSequence detections;
  int64_t first_frame = 0;  // that is written
  FrozenMatches matches;
  TrackSequence tracks;  // what the run itself wrote
};

// Tracks detections in memory and freezes the matches, with cameras and clocks
// refined before, where the options ask for it. There is one pass: a second one
// (tracking.second_pass) is left out, and the world stays where it is.
FrozenRun FreezeTracking(const RunOptions& options, const RunRequest& request,
                         const DetectionSequence& detections);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SESSION_RUN_H_
