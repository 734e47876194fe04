// Whether a frame of detections is what its header says.
#ifndef KINEGRAPH_CORE_DATA_DETECTION_CHECK_H_
#define KINEGRAPH_CORE_DATA_DETECTION_CHECK_H_

#include <string>

#include "core/data/detection.h"

namespace kinegraph {

// Throws InputError naming the view when its own clock and its frame's are
// farther apart than 10 s, as far as the doctor looks for lags: then they count
// from another beginning.
void CheckCaptureTime(const std::string& view, TimeNs capture_time,
                      TimeNs frame_time);

// Throws InputError naming the frame unless it has one view for each of the
// header's and each detection one joint for each of the skeleton's, found ones
// at finite numbers, and its time is a time and the clocks of the views fit it.
void CheckDetectionFrame(const DetectionHeader& header,
                         const DetectionFrame& frame);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_DATA_DETECTION_CHECK_H_
