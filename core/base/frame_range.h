// Ranges of frames, as used by flags and evaluation protocols.
#ifndef KINEGRAPH_CORE_BASE_FRAME_RANGE_H_
#define KINEGRAPH_CORE_BASE_FRAME_RANGE_H_

#include <algorithm>
#include <cstdint>
#include <vector>

namespace kinegraph {

// Frames begin .. end - 1.
struct FrameRange {
  int64_t begin = 0;
  int64_t end = 0;

  bool Contains(int64_t frame) const { return frame >= begin && frame < end; }
};

// Whether `ranges` contain the frame; without any range every frame counts.
inline bool ContainsFrame(const std::vector<FrameRange>& ranges,
                          int64_t frame) {
  return ranges.empty() || std::any_of(ranges.begin(), ranges.end(),
                                       [frame](const FrameRange& range) {
                                         return range.Contains(frame);
                                       });
}

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_BASE_FRAME_RANGE_H_
