// How surely a point lies within a distance of where it is said to be.
#ifndef KINEGRAPH_CORE_GEOMETRY_BALL_PROBABILITY_H_
#define KINEGRAPH_CORE_GEOMETRY_BALL_PROBABILITY_H_

#include <Eigen/Core>

namespace kinegraph {

// Probability that a Gaussian of mean 0 and this covariance [m^2], symmetric
// and not negative, lies within a ball of `radius_m` > 0 around 0; to 1e-5, by
// quadrature over the two longer axes.
double ProbabilityWithin(double radius_m, const Eigen::Matrix3d& covariance_m2);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_GEOMETRY_BALL_PROBABILITY_H_
