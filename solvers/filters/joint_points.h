// Where the points come from that filters smooth.
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
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Identity();  // if asked for
};

// Points of one person. A joint has a point in a frame that two or more of the
// frame's own views support: those that the joints filter kept, or those that
// robust triangulation gives weight. Nothing comes from views of older frames.
//
// Sigmas (PixelSigma) are those at the depth of the person's last initial pose.
class JointPoints {
 public:
  // With covariances kDlt's are those of the views kept; a joint whose views
  // leave a direction open then has no point.
  JointPoints(const SceneModel& scene, PointKind kind,
              PointCovariances covariances,
              const RobustTriangulationOptions& robust,
              const GraphOptions& noise);

  // Points of a frame, one a joint. `person` (as DescribeViews fills it) gets
  // the robust triangulation's inlier views and weights.
  void Find(const EstimatorFrame& frame,
            std::vector<std::optional<JointPoint>>* points, PersonPose* person);

 private:
  enum class Views { kAll, kKeptByFilter };
  // Fills views_ with the frame's measurements of a joint and slots_ with their
  // places among the frame's views.
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
