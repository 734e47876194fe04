// The unknowns of one joint at one frame.
#ifndef KINEGRAPH_SOLVERS_FACTORS_STATE_H_
#define KINEGRAPH_SOLVERS_FACTORS_STATE_H_

#include <Eigen/Core>

#include "solvers/factors/jacobian.h"

namespace kinegraph {

// Position [m] and velocity [m/s] in the world, one parameter block.
using State = Eigen::Matrix<double, kStateSize, 1>;
using Matrix6d = Eigen::Matrix<double, kStateSize, kStateSize>;

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FACTORS_STATE_H_
