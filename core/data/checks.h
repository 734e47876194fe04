// Checks of detections and of cameras' names, and of the plausibility of a
// run's results.
#ifndef KINEGRAPH_CORE_DATA_CHECKS_H_
#define KINEGRAPH_CORE_DATA_CHECKS_H_

#include <string>
#include <string_view>

#include "core/data/detection.h"
#include "core/data/pose.h"
#include "core/geometry/camera.h"

namespace kinegraph {

// Throw InputError, beginning with `key`, for numbers beyond the bounds of
// limits.h. A rate of 0 means unknown and is accepted; CheckedTime returns the
// time in nanoseconds.
void CheckFrameRate(double rate_hz, std::string_view key);
TimeNs CheckedTime(double seconds, std::string_view key);

// Throws InputError unless there are views with distinct names and a valid
// frame rate.
void CheckDetectionHeader(const DetectionHeader& header);

// Throws InputError unless the cameras have distinct, non-empty names.
void CheckCameraNames(const CameraRig& cameras);

// Throws InputError naming the view when its capture time and the frame's time
// differ by more than 10 s, the range in which `kinegraph doctor` searches for
// lags: the two clocks then have different origins.
void CheckCaptureTime(const std::string& view, TimeNs capture_time,
                      TimeNs frame_time);

// Throws InputError naming the frame unless it has one view per view of the
// header, each detection one joint per joint of the skeleton with finite
// numbers for found joints, and its number and time are within limits.h. Throws
// what CheckCaptureTime throws.
void CheckDetectionFrame(const DetectionHeader& header,
                         const DetectionFrame& frame);

// Checks the results of a run before they are written. A failure is a bug of
// this program, whatever the input.
class PoseCheck {
 public:
  explicit PoseCheck(const CameraRig& cameras);

  // Throws std::logic_error naming frame, person and joint unless all positions
  // are finite and, unless all cameras coincide, within a billion times the
  // extent of the cameras, and each covariance is finite, symmetric and, up to
  // rounding, positive semidefinite but not zero.
  void Require(const TrackHeader& header, const TrackFrame& frame) const;

 private:
  Eigen::Vector3d centre_m_ = Eigen::Vector3d::Zero();  // of the cameras
  double farthest_m_ = 0.0;  // greatest plausible distance from centre_m_
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_DATA_CHECKS_H_
