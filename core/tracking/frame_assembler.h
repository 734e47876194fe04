// Puts the final poses of all tracks together into frames, in order.
#ifndef KINEGRAPH_CORE_TRACKING_FRAME_ASSEMBLER_H_
#define KINEGRAPH_CORE_TRACKING_FRAME_ASSEMBLER_H_

#include <cstdint>
#include <deque>
#include <vector>

#include "core/base/ids.h"
#include "core/data/pose.h"

namespace kinegraph {

// A frame leaves when every track that lived in it has said its last word on
// it. Tracks speak in ascending frames, each frame of their life once.
class FrameAssembler {
 public:
  // The next frame; ascending. People that live in it follow by Join.
  void BeginFrame(int64_t frame, TimeNs time);
  // The newest frame waits for a word of this track.
  void Join() { ++open_.back().waiting; }
  // A track's word on a frame; `person` is null when it is not written.
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

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_TRACKING_FRAME_ASSEMBLER_H_
