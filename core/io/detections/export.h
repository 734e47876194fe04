// Writing 2D detections in the formats of detectors.
#ifndef KINEGRAPH_CORE_IO_DETECTIONS_EXPORT_H_
#define KINEGRAPH_CORE_IO_DETECTIONS_EXPORT_H_

#include <string>

#include "core/io/detections/format.h"

namespace kinegraph {

// As DetectionFormat::Write.

// OpenPose's layout: VIEW/VIEW_FFFFFFFFFFFF_keypoints.json for every view and
// frame, also where nobody was seen; a missing joint is 0, 0, 0.
void WriteOpenPose(const std::string& path,
                   const DetectionWriteOptions& options,
                   DetectionSource* source, LostFields* lost_fields);

// Our own format, JSON Lines.
void WriteKinegraphDetections(const std::string& path,
                              const DetectionWriteOptions& options,
                              DetectionSource* source, LostFields* lost_fields);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_DETECTIONS_EXPORT_H_
