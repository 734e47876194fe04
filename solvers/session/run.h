// Whole tracking runs over detections in files, in memory or in a stream; used
// by every command that tracks.
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

// Detections held in memory as a source; another MemorySource reads them again.
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

// Provides the detections of written frames: from the frames passed to Feed,
// which are kept until they are final, or, if all frames become final only at
// the end, by reading the recording again.
class UsedFrames {
 public:
  // Without `reopen`, frames come from Feed. `scene` must outlive this object.
  UsedFrames(const RunScene& scene, SourceOpener reopen);
  // `used` has the used views only; ignored with `reopen`.
  void Feed(const DetectionFrame& used);
  // The used views of a frame, valid until the next call; nullptr if the frame
  // does not exist. Frames must be requested in ascending order.
  const DetectionFrame* At(int64_t frame);

 private:
  const RunScene* scene_;
  SourceOpener reopen_;
  std::unique_ptr<DetectionSource> source_;
  std::deque<DetectionFrame> waiting_;
  DetectionFrame read_;
  DetectionFrame current_;
};

// Passes the frames of `source`, up to the end of RunRequest::frames, to
// `session` and finishes it; `write` receives the finished frames in order.
void TrackAll(DetectionSource* source, Session* session,
              const std::function<void(TrackFrame&&)>& write);

// Tracks detections in memory, after refining cameras and clocks and moving the
// world onto its floor (z = 0) if the options request it. `view_bias`, if not
// null, receives the learnt bias of the detector; `progress`, if not empty, is
// called with the number of frames read so far.
TrackSequence TrackSequenceOf(
    const RunOptions& options, const RunRequest& request,
    const DetectionSequence& detections, ViewBias* view_bias = nullptr,
    const std::function<void(int64_t)>& progress = nullptr);

// A run whose matches are kept (core/tracking/replay.h).
struct FrozenRun {
  RunScene scene;      // cameras in the run's unit of length
  SubjectScale scale;  // defines that unit
  // As passed to the tracker: only used views, with the repetitions of the
  // first frame (input.repeat_first_frame) before `first_frame`.
  DetectionSequence detections;
  int64_t first_frame = 0;  // the first frame written
  FrozenMatches matches;
  TrackSequence tracks;  // output of the run itself, in metres of the world
};

// Tracks detections in memory and freezes the matches, after refining cameras
// and clocks if the options request it. Runs a single pass without linking
// identities, regardless of tracking.second_pass and identity.link, and ignores
// cameras.ground.
FrozenRun FreezeTracking(const RunOptions& options, const RunRequest& request,
                         const DetectionSequence& detections);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SESSION_RUN_H_
