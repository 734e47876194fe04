// Detectors whose confidences are small throughout.
#ifndef KINEGRAPH_SOLVERS_SCENE_CONFIDENCE_SCALE_H_
#define KINEGRAPH_SOLVERS_SCENE_CONFIDENCE_SCALE_H_

#include <vector>

#include "core/data/detection.h"

namespace kinegraph {

// Checks of cameras and clocks leave out joints below a confidence of 0.3,
// which is meant for detectors whose joints have 0.6 and more as a rule. The
// factor that brings the median of a recording's joints that were found to 0.6;
// 1 where it is no less, or nothing is known.
double ConfidenceScale(std::vector<double> confidences);

// Appends the confidences of the joints that were found.
void CollectConfidences(const DetectionFrame& frame,
                        std::vector<double>* confidences);

void ScaleConfidences(double factor, DetectionFrame* frame);

// All frames by their common scale.
DetectionSequence WithUsualConfidences(DetectionSequence detections);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SCENE_CONFIDENCE_SCALE_H_
