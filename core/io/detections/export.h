// Writing 2D detections in the formats of detectors.
#ifndef KINEGRAPH_CORE_IO_DETECTIONS_EXPORT_H_
#define KINEGRAPH_CORE_IO_DETECTIONS_EXPORT_H_

#include <string>

#include "core/io/detections/format.h"

namespace kinegraph {

// The first two write a folder. All appear when they are complete, take the
// frames one by one from `source`. A missing joint is 0, 0, 0. Throw InputError
// when the folder cannot be made or a view cannot be the name of a file. What
// the format leaves out is added to `losses`.

// OpenPose's layout: VIEW/VIEW_FFFFFFFFFFFF_keypoints.json for every view and
// frame, also where nobody was seen.
void WriteOpenPose(const std::string& path,
                   const DetectionWriteOptions& options,
                   DetectionSource* source, LostFields* lost_fields);

// COCO keypoint results, VIEW.json. The score of a person is the mean
// confidence of the joints found, the box the one around them.
void WriteCocoResults(const std::string& path,
                      const DetectionWriteOptions& options,
                      DetectionSource* source, LostFields* lost_fields);

// longcw's annotation_2d.json, one file. Frames are told by their times alone,
// so it needs a frame rate; it names the image size, which it must be given.
void WriteLongcwDetections(const std::string& path,
                           const DetectionWriteOptions& options,
                           DetectionSource* source, LostFields* lost_fields);

// Our own format, JSON Lines.
void WriteKinegraphDetections(const std::string& path,
                              const DetectionWriteOptions& options,
                              DetectionSource* source, LostFields* lost_fields);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_DETECTIONS_EXPORT_H_
