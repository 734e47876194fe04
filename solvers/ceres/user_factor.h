// A user's own ceres::CostFunction as a factor of every person.
//
//   GraphOptions options;
//   options.user_factors = [](const UserFrame& frame) {
//     std::vector<UserFactor> factors;
//     factors.push_back({FromCeres(new MyCost()), {{joint, 0}}});
//     return factors;
//   };
#ifndef KINEGRAPH_SOLVERS_CERES_USER_FACTOR_H_
#define KINEGRAPH_SOLVERS_CERES_USER_FACTOR_H_

#include <memory>

#include "solvers/graph/general_factor.h"

namespace ceres {
class CostFunction;  // ceres/cost_function.h
}

namespace kinegraph {

// Takes ownership. Each of the cost's parameter blocks is a state [p; v] [m,
// m/s]; residuals must be whitened. Throws OptionError for blocks of another
// size.
std::shared_ptr<const GeneralFactor> FromCeres(ceres::CostFunction* cost);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_CERES_USER_FACTOR_H_
