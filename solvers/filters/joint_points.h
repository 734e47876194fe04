// Triangulated points, the input of the filters.
#ifndef KINEGRAPH_SOLVERS_FILTERS_JOINT_POINTS_H_
#define KINEGRAPH_SOLVERS_FILTERS_JOINT_POINTS_H_

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/tracking/estimator.h"
#include "solvers/filters/options.h"
#include "solvers/filters/robust_triangulation.h"
#include "solvers/graph/options.h"

namespace kinegraph {

// Whether points come with covariances. kRobust always has them.
enum class PointCovariances { kOff, kOn };

struct JointPoint {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Identity();  // if requested
};

// Points of one person. A joint has a point in a frame if two or more of the
// frame's own views support it: views that the tracker's epipolar filter kept
// (kDlt), or that have at least kInlierWeight in the robust triangulation
// (kRobust). The positions of kDlt are those of the initial pose, to which
// older views within the age limit also contribute.
//
// Sigmas (PixelSigma) refer to the depth of the person's last initial pose.
class JointPoints {
 public:
  // The covariances of kDlt are computed from the kept views; if they are
  // requested, a joint whose views leave a direction undetermined has no point.
  JointPoints(const SceneModel& scene, PointKind kind,
              PointCovariances covariances,
              const RobustTriangulationOptions& robust,
              const GraphOptions& noise);

  // Points of a frame, one per joint. With kRobust, writes the triangulation's
  // inlier views and weights to `person` (as filled by DescribeViews).
  void Find(const EstimatorFrame& frame,
            std::vector<std::optional<JointPoint>>* points, PersonPose* person);

 private:
  enum class Views { kAll, kKeptByFilter };
  // Fills views_ with the frame's measurements of a joint and slots_ with their
  // indices among the frame's views.
  void CollectViews(const EstimatorFrame& frame, size_t joint_idx, Views which);
  std::optional<JointPoint> FromInitialPose(const EstimatorFrame& frame,
                                            size_t joint_idx);
  std::optional<JointPoint> FromViews(const EstimatorFrame& frame,
                                      size_t joint_idx, PersonPose* person);

  CameraRig cameras_;
  Skeleton skeleton_;
  PointKind kind_;
  PointCovariances covariances_;
  RobustTriangulator robust_;
  GraphOptions noise_;
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();  // of the person
  // Scratch.
  std::vector<PixelPoint> views_;
  std::vector<size_t> slots_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FILTERS_JOINT_POINTS_H_
