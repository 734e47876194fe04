#include "core/io/detections/lost_fields.h"

#include <algorithm>

#include "core/io/text/bulk_json.h"
#include "core/io/text/names.h"

namespace kinegraph {

DetectionLossFinder::DetectionLossFinder(const DetectionHeader& header)
    : header_(header) {}

void DetectionLossFinder::See(const DetectionFrame& frame) {
  const TimeNs regular = TimeOfFrame(frame.frame, header_.frame_rate_hz);
  own_times_ = own_times_ || frame.time != regular;
  for (const ViewDetections& view : frame.views) {
    own_times_ = own_times_ || view.capture_time != frame.time;
    int place = 0;
    for (const Detection& detection : view.detections) {
      moved_ += detection.index_in_file != place++ ? 1 : 0;
      zero_confidence_joints_ +=
          std::count_if(detection.joints.begin(), detection.joints.end(),
                        [](const Keypoint& joint) {
                          return joint.found && !(joint.confidence > 0.0);
                        });
    }
  }
}

void DetectionLossFinder::Report(bool skeleton_told, LostFields* lost_fields,
                                 bool rate_told) const {
  if (header_.frame_rate_hz > 0.0 && !rate_told) {
    lost_fields->push_back("the frame rate is not kept");
  }
  if (own_times_) {
    lost_fields->push_back("times other than frame / frame rate are not kept");
  }
  if (!skeleton_told) {
    lost_fields->push_back("the file does not tell the skeleton '" +
                           header_.skeleton.name() +
                           "': name it when reading (detections.skeleton)");
  }
  if (zero_confidence_joints_ > 0) {
    lost_fields->push_back(std::to_string(zero_confidence_joints_) +
                           " joints with confidence 0 read as missing unless "
                           "detections.zero_confidence = \"position\"");
  }
  if (moved_ > 0) {
    lost_fields->push_back("people without joints are left out, so that " +
                           std::to_string(moved_) +
                           " detections get another index in their frame");
  }
  if (!std::is_sorted(header_.view_names.begin(), header_.view_names.end(),
                      NaturalLess)) {
    lost_fields->push_back("views are read back in the order of their names");
  }
}

}  // namespace kinegraph
