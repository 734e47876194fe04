// Whether what a run says of people can be true.
#ifndef KINEGRAPH_CORE_DATA_POSE_CHECK_H_
#define KINEGRAPH_CORE_DATA_POSE_CHECK_H_

#include "core/data/pose.h"
#include "core/geometry/camera.h"

namespace kinegraph {

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

#endif  // KINEGRAPH_CORE_DATA_POSE_CHECK_H_
