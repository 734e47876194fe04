// Whether a frame of detections is what its header says, and whether what a run
// says of people can be true.
#ifndef KINEGRAPH_CORE_DATA_CHECKS_H_
#define KINEGRAPH_CORE_DATA_CHECKS_H_

#include <string>
#include <string_view>

#include "core/data/detection.h"
#include "core/data/pose.h"
#include "core/geometry/camera.h"

namespace kinegraph {

// Throw InputError, beginning with `key`, beyond the bounds of limits.h. A rate
// of 0 is one that is not known.
void CheckFrameRate(double rate_hz, std::string_view key);
TimeNs CheckedTime(double seconds, std::string_view key);

// Throws InputError unless there are views, each name stands there once, and
// the frame rate is one.
void CheckDetectionHeader(const DetectionHeader& header);

// Throws InputError unless each camera has a name of its own.
void CheckCameraNames(const CameraRig& cameras);

// Throws InputError naming the view when its own clock and its frame's are
// farther apart than 10 s, as far as the doctor looks for lags: then they count
// from another beginning.
void CheckCaptureTime(const std::string& view, TimeNs capture_time,
                      TimeNs frame_time);

// Throws InputError naming the frame unless it has one view for each of the
// header's and each detection one joint for each of the skeleton's, found ones
// at finite numbers, and its number and time are within limits.h and the clocks
// of the views fit it.
void CheckDetectionFrame(const DetectionHeader& header,
                         const DetectionFrame& frame);

// The numbers of a run before they leave it. They are of our own making: what
// is wrong with them is a fault of ours, whatever the input.
class PoseCheck {
 public:
  explicit PoseCheck(const CameraRig& cameras);

  // Throws std::logic_error naming frame, person and joint unless all positions
  // are finite and within a billion times the extent of the cameras, and each
  // covariance is finite, symmetric and, but for rounding, positive definite.
  void Require(const TrackHeader& header, const TrackFrame& frame) const;

 private:
  Eigen::Vector3d centre_m_ = Eigen::Vector3d::Zero();  // of the cameras
  double farthest_m_ = 0.0;  // that anybody may be from there
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_DATA_CHECKS_H_
