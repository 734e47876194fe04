// Detections of frames, kept until the poses of these frames are final.
#ifndef KINEGRAPH_SOLVERS_SESSION_USED_FRAMES_H_
#define KINEGRAPH_SOLVERS_SESSION_USED_FRAMES_H_

#include <cstdint>
#include <deque>
#include <memory>

#include "core/data/detection.h"
#include "solvers/session/scene.h"
#include "solvers/session/session.h"

namespace kinegraph {

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

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SESSION_USED_FRAMES_H_
