// Propagates the uncertainty of refined cameras and clocks to the joints.
//
// An estimator assumes exact cameras, so its covariance P is that of a joint
// given the cameras. The marginal covariance of joint x, with the cameras c
// uncertain, is (by the Schur complement of the cameras' block)
//   cov(x) = P + S cov(c) S^T,
//   S = dx/dc = -(sum J_x^T W J_x)^-1 sum J_x^T W J_c,
// with sums over the views that saw the joint in the frame. Smoothing over time
// does not change S as long as the same views see the joint, because the
// cameras' errors are the same in all frames.
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
  // `places`: uncertain components of each view's change (camera_change.h);
  // `covariance`: of all these, view by view, at the given cameras.
  // `detection_joint`: for each joint of the tracks, the index of the
  // detections' joint, or -1. Drift is relative to `clock_zero_s`.
  CameraUncertainty(CameraRig cameras, std::vector<std::vector<int>> places,
                    Eigen::MatrixXd covariance,
                    std::vector<int> detection_joint, double clock_zero_s);

  // Adds to the covariances of a frame's people, whose matches must include
  // weights. Joints seen by fewer than two views receive the mean addition of
  // the person's other joints, if there are any; those without a covariance are
  // skipped. To be called in the order of frames.
  void AddTo(const DetectionFrame& seen, TrackFrame* frame);

 private:
  using Sensitivity = Eigen::Matrix<double, 3, Eigen::Dynamic>;

  // dx/dc of a joint; nullopt if fewer than two views observe it. `since_s`:
  // time of the frame since clock_zero_s_.
  std::optional<Sensitivity> Of(const DetectionFrame& seen,
                                const PersonPose& person, size_t joint,
                                const Eigen::Vector3d& velocity_mps,
                                double since_s) const;
  // Mean velocity since the person's previous frame, `passed_s` ago; zero if
  // that frame lacks the person or the joint.
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
  std::map<TrackId, Last> last_;  // people of the previous frame
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_CAMERAS_CAMERA_UNCERTAINTY_H_
