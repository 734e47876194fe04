#include "core/io/detections/summary.h"

namespace kinegraph {

DetectionSummary Summarise(const Detection& detection) {
  DetectionSummary summary;
  for (const Keypoint& joint : detection.joints) {
    if (!joint.found) continue;
    const bool is_first = summary.found++ == 0;
    summary.low_px = is_first ? joint.px : summary.low_px.cwiseMin(joint.px);
    summary.high_px = is_first ? joint.px : summary.high_px.cwiseMax(joint.px);
    summary.score += joint.confidence;
  }
  if (summary.found > 0) summary.score /= summary.found;
  return summary;
}

}  // namespace kinegraph
