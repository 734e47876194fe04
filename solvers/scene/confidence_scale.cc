#include "solvers/scene/confidence_scale.h"

#include <utility>
#include <vector>

#include "core/base/median.h"

namespace kinegraph {
namespace {

template <typename Visit>
void ForEachJoint(DetectionSequence* detections, const Visit& visit) {
  for (DetectionFrame& frame : detections->frames) {
    for (ViewDetections& view : frame.views) {
      for (Detection& detection : view.detections) {
        for (Keypoint& joint : detection.joints) visit(&joint);
      }
    }
  }
}

}  // namespace

DetectionSequence WithUsualConfidences(DetectionSequence detections) {
  constexpr double kUsual = 0.6;
  std::vector<double> confidences;
  ForEachJoint(&detections, [&](const Keypoint* joint) {
    if (joint->found) confidences.push_back(joint->confidence);
  });
  if (confidences.empty()) return detections;
  const double median = Median(std::move(confidences));
  if (!(median > 0.0 && median < kUsual)) return detections;
  ForEachJoint(&detections,
               [&](Keypoint* joint) { joint->confidence *= kUsual / median; });
  return detections;
}

}  // namespace kinegraph
