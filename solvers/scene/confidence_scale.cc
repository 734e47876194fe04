#include "solvers/scene/confidence_scale.h"

#include <utility>

#include "core/base/median.h"

namespace kinegraph {

double ConfidenceScale(std::vector<double> confidences) {
  constexpr double kUsual = 0.6;
  if (confidences.empty()) return 1.0;
  const double median = Median(std::move(confidences));
  return median > 0.0 && median < kUsual ? kUsual / median : 1.0;
}

void CollectConfidences(const DetectionFrame& frame,
                        std::vector<double>* confidences) {
  for (const ViewDetections& view : frame.views) {
    for (const Detection& detection : view.detections) {
      for (const Keypoint& joint : detection.joints) {
        if (joint.found) confidences->push_back(joint.confidence);
      }
    }
  }
}

void ScaleConfidences(double factor, DetectionFrame* frame) {
  if (factor == 1.0) return;
  for (ViewDetections& view : frame->views) {
    for (Detection& detection : view.detections) {
      for (Keypoint& joint : detection.joints) joint.confidence *= factor;
    }
  }
}

DetectionSequence WithUsualConfidences(DetectionSequence detections) {
  std::vector<double> confidences;
  for (const DetectionFrame& frame : detections.frames) {
    CollectConfidences(frame, &confidences);
  }
  const double factor = ConfidenceScale(std::move(confidences));
  for (DetectionFrame& frame : detections.frames) {
    ScaleConfidences(factor, &frame);
  }
  return detections;
}

}  // namespace kinegraph
