// Probability that a point lies within a distance of its estimate.
#ifndef KINEGRAPH_CORE_GEOMETRY_BALL_PROBABILITY_H_
#define KINEGRAPH_CORE_GEOMETRY_BALL_PROBABILITY_H_

#include <Eigen/Core>

namespace kinegraph {

// Probability that a Gaussian of mean 0 and this positive semidefinite
// covariance [m^2] lies within a ball of `radius_m` > 0 around 0; accurate to
// 1e-5, by quadrature over the two longer axes.
double ProbabilityWithin(double radius_m, const Eigen::Matrix3d& covariance_m2);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_GEOMETRY_BALL_PROBABILITY_H_
