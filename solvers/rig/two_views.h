// The pose of one view in another's frame from points that both see.
// Hartley and Zisserman, Multiple View Geometry, chapters 9 and 11.
#ifndef KINEGRAPH_SOLVERS_RIG_TWO_VIEWS_H_
#define KINEGRAPH_SOLVERS_RIG_TWO_VIEWS_H_

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace kinegraph {

// One point in both views, in normalised image coordinates as a guess of the
// focal lengths has them.
struct PointPair {
  Eigen::Vector2d a = Eigen::Vector2d::Zero();
  Eigen::Vector2d b = Eigen::Vector2d::Zero();
  // Distances count in these [normalised coordinates]: the size of the person
  // in both views, geometric mean.
  double size = 1.0;
};

// x_b = R x_a + t up to the length of t, which is one. Normalised coordinates
// are those of the guess divided by `magnification`: the focal lengths are so
// many times the guess, both of them.
struct RelativePose {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::UnitX();
  double magnification = 1.0;

  Eigen::Matrix3d Essential() const;
};

// Squared distance of a pair from the epipolar geometry of `essential`
// (Sampson, first order), in sizes of the person.
double SampsonSquared(const Eigen::Matrix3d& essential, double magnification,
                      const PointPair& pair);

// Of the four poses of the same epipolar geometry the one in which most pairs
// lie in front of both views.
RelativePose WithMostInFront(const std::vector<PointPair>& pairs,
                             const RelativePose& pose);

// Sum of the robust costs that RefinePose makes least.
double RobustCost(const std::vector<PointPair>& pairs, const RelativePose& pose,
                  double scale);

// The normalised eight-point algorithm for eight pairs and more. nullopt
// where they leave it open: all in a plane, no baseline.
std::optional<RelativePose> EightPoint(const std::vector<PointPair>& pairs,
                                       double magnification);

// Depths in both views of a pair's midpoint, for a baseline of one; nullopt
// where the rays are nearly parallel.
std::optional<Eigen::Vector2d> DepthsOf(const RelativePose& pose,
                                        const PointPair& pair);

// The pose of least robust Sampson distances near `start` (Levenberg and
// Marquardt on rotation, direction and, where `focal_sigma` is not zero, the
// logarithm of the magnification with that prior). `scale`: Cauchy's, in sizes
// of the person.
RelativePose RefinePose(const std::vector<PointPair>& pairs,
                        const RelativePose& start, double scale,
                        double focal_sigma);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_RIG_TWO_VIEWS_H_
