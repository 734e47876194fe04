#include "core/data/detection.h"

#include <algorithm>

namespace kinegraph {

const DetectionFrame* FindDetectionFrame(const DetectionSequence& detections,
                                         int64_t frame) {
  const auto at = std::lower_bound(
      detections.frames.begin(), detections.frames.end(), frame,
      [](const DetectionFrame& one, int64_t f) { return one.frame < f; });
  if (at == detections.frames.end() || at->frame != frame) return nullptr;
  return &*at;
}

int CountFound(const Detection& detection) {
  return static_cast<int>(
      std::count_if(detection.joints.begin(), detection.joints.end(),
                    [](const Keypoint& joint) { return joint.found; }));
}

Detection Convert(const Detection& detection, const std::vector<int>& map) {
  Detection converted;
  converted.index_in_file = detection.index_in_file;
  converted.joints.resize(map.size());
  for (size_t j = 0; j < map.size(); ++j) {
    if (map[j] >= 0) converted.joints[j] = detection.joints[map[j]];
  }
  return converted;
}

}  // namespace kinegraph
