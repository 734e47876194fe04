// What detectors' formats leave out of detections. For core/io alone.
#ifndef KINEGRAPH_CORE_IO_DETECTIONS_LOST_FIELDS_H_
#define KINEGRAPH_CORE_IO_DETECTIONS_LOST_FIELDS_H_

#include <cstdint>

#include "core/data/detection.h"
#include "core/io/text/lost_fields.h"

namespace kinegraph {

// Watches what is written by a format that stores frame numbers, x, y and
// confidence only.
class DetectionLossFinder {
 public:
  explicit DetectionLossFinder(const DetectionHeader& header);
  void See(const DetectionFrame& frame);
  // `skeleton_told` says whether a reader recognises the skeleton by the file,
  // `rate_told` whether it assumes the right frame rate.
  void Report(bool skeleton_told, LostFields* lost_fields,
              bool rate_told = false) const;

 private:
  DetectionHeader header_;
  int64_t zero_confidence_joints_ = 0;
  int64_t moved_ = 0;  // detections whose index in the frame changes
  bool own_times_ = false;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_DETECTIONS_LOST_FIELDS_H_
