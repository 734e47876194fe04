// Relative pose of two views from points seen in both. Hartley and Zisserman,
// Multiple View Geometry, chapters 9 and 11.
#ifndef KINEGRAPH_SOLVERS_RIG_TWO_VIEWS_H_
#define KINEGRAPH_SOLVERS_RIG_TWO_VIEWS_H_

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace kinegraph {

// One point in both views, in image coordinates normalised with the assumed
// focal lengths.
struct PointPair {
  Eigen::Vector2d a = Eigen::Vector2d::Zero();
  Eigen::Vector2d b = Eigen::Vector2d::Zero();
  // Unit of distances [normalised coordinates]: geometric mean of the person's
  // size in both views.
  double size = 1.0;
};

// x_b = R x_a + t with |t| = 1. Points of a PointPair are divided by
// `magnification`: the focal lengths are the assumed values times
// `magnification`.
struct RelativePose {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::UnitX();
  double magnification = 1.0;

  Eigen::Matrix3d Essential() const;
};

// Squared first-order (Sampson) distance of a pair from the epipolar geometry
// of `essential`, in units of the person's size.
double SampsonSquared(const Eigen::Matrix3d& essential, double magnification,
                      const PointPair& pair);

// Of the four poses with the same epipolar geometry, the one that puts the most
// pairs in front of both views.
RelativePose WithMostInFront(const std::vector<PointPair>& pairs,
                             const RelativePose& pose);

// The robust cost that RefinePose minimises, without its prior.
double RobustCost(const std::vector<PointPair>& pairs, const RelativePose& pose,
                  double scale);

// The normalised eight-point algorithm. nullopt for fewer than eight pairs and
// for pairs that do not determine a pose, because all points are coplanar or
// there is no baseline.
std::optional<RelativePose> EightPoint(const std::vector<PointPair>& pairs,
                                       double magnification);

// Depths of a pair's point in both views, for a baseline of length one; nullopt
// if the rays are nearly parallel.
std::optional<Eigen::Vector2d> DepthsOf(const RelativePose& pose,
                                        const PointPair& pair);

// Minimises the robust Sampson distances, beginning at `start`
// (Levenberg-Marquardt over rotation, direction of t and, unless `focal_sigma`
// is 0, the logarithm of the magnification with a normal prior of this sigma).
// `scale`: of the Cauchy loss, in units of the person's size.
RelativePose RefinePose(const std::vector<PointPair>& pairs,
                        const RelativePose& start, double scale,
                        double focal_sigma);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_RIG_TWO_VIEWS_H_
