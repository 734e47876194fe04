// Detectors whose confidences are small throughout.
#ifndef KINEGRAPH_SOLVERS_SCENE_CONFIDENCE_SCALE_H_
#define KINEGRAPH_SOLVERS_SCENE_CONFIDENCE_SCALE_H_

#include "core/data/detection.h"

namespace kinegraph {

// Checks of cameras and clocks leave out joints below a confidence of 0.3,
// which is meant for detectors whose joints have 0.6 and more as a rule. All
// confidences by the factor that brings the median of the joints found to 0.6,
// where it is less.
DetectionSequence WithUsualConfidences(DetectionSequence detections);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SCENE_CONFIDENCE_SCALE_H_
