// What COCO's files say of a person beside the joints. For core/io alone.
#ifndef KINEGRAPH_CORE_IO_DETECTIONS_SUMMARY_H_
#define KINEGRAPH_CORE_IO_DETECTIONS_SUMMARY_H_

#include <Eigen/Core>

#include "core/data/detection.h"

namespace kinegraph {

// Of the joints that were found; zeros when there are none.
struct DetectionSummary {
  double score = 0.0;  // mean confidence
  int found = 0;
  Eigen::Vector2d low_px = Eigen::Vector2d::Zero();  // the box around them
  Eigen::Vector2d high_px = Eigen::Vector2d::Zero();
};

DetectionSummary Summarise(const Detection& detection);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_DETECTIONS_SUMMARY_H_
