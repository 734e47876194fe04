#include "core/data/detection.h"

#include <algorithm>

namespace kinegraph {

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
