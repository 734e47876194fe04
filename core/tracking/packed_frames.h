// What a person's estimator is given, in little memory: for takes whose people
// all wait for the end.
#ifndef KINEGRAPH_CORE_TRACKING_PACKED_FRAMES_H_
#define KINEGRAPH_CORE_TRACKING_PACKED_FRAMES_H_

#include <cstddef>

#include "core/base/byte_queue.h"
#include "core/tracking/estimator.h"

namespace kinegraph {

// A queue of frames. What was measured and the initial pose come back bit by
// bit; what the joints filter said of views (verdicts, inlier views) is not
// kept.
class PackedFrames {
 public:
  void Push(const EstimatorFrame& frame);
  size_t size() const { return frames_.size(); }
  bool empty() const { return frames_.empty(); }
  // Takes the oldest frame out.
  void Pop(EstimatorFrame* frame);

 private:
  ByteQueue frames_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_TRACKING_PACKED_FRAMES_H_
