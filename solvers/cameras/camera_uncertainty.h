// What the uncertainty of refined cameras and clocks does to the joints.
//
// An estimator takes the cameras as they are, so its covariance P is that of a
// joint given the cameras. Eliminating cameras c and joint x together instead
// of one after the other (the Schur complement of the cameras' block) gives
//   cov(x) = P + S cov(c) S^T,  S = dx/dc = -(sum J_x^T W J_x)^-1 sum J_x^T W
//   J_c
// over the views that saw the joint in the frame. Smoothing over time does not
// change S as long as the same views see the joint: the cameras' errors stay
// the same from frame to frame.
#ifndef KINEGRAPH_SOLVERS_CAMERAS_CAMERA_UNCERTAINTY_H_
#define KINEGRAPH_SOLVERS_CAMERAS_CAMERA_UNCERTAINTY_H_

#include <Eigen/Core>
#include <map>
#include <optional>
#include <vector>

#include "core/data/detection.h"
#include "core/data/pose.h"
#include "core/geometry/camera.h"

namespace kinegraph {

class CameraUncertainty {
 public:
  // `places` of each view's change that are uncertain (camera_change.h) and the
  // covariance of all of them, view after view, at the cameras as they are now.
  // `detection_joint` of each joint of the tracks, or -1. Drifts count from
  // `clock_zero_s`.
  CameraUncertainty(CameraRig cameras, std::vector<std::vector<int>> places,
                    Eigen::MatrixXd covariance,
                    std::vector<int> detection_joint, double clock_zero_s);

  // Adds to the covariances of a frame's people, which need their matches;
  // joints without a covariance get none. Frames ascend.
  void AddTo(const DetectionFrame& seen, TrackFrame* frame);

 private:
  using Sensitivity = Eigen::Matrix<double, 3, Eigen::Dynamic>;

  // dx/dc of a joint; nullopt when fewer than two views say where it is.
  std::optional<Sensitivity> Of(const DetectionFrame& seen,
                                const PersonPose& person, size_t joint,
                                const Eigen::Vector3d& velocity_mps,
                                double since_s) const;
  Eigen::Vector3d VelocityOf(const PersonPose& person, size_t joint,
                             double passed_s) const;
  void AddToPerson(const DetectionFrame& seen, double passed_s, double since_s,
                   PersonPose* person) const;

  struct Last {
    TimeNs time = 0;
    Pose3d joints;
  };

  CameraRig cameras_;
  std::vector<std::vector<int>> places_;
  std::vector<Eigen::Index> begin_;
  Eigen::MatrixXd covariance_;
  std::vector<int> detection_joint_;
  double clock_zero_s_;
  std::map<TrackId, Last> last_;  // of the frame before
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_CAMERAS_CAMERA_UNCERTAINTY_H_
