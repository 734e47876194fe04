// What is known of a joint before anything was measured.
#ifndef KINEGRAPH_SOLVERS_FACTORS_BIRTH_PRIOR_FACTOR_H_
#define KINEGRAPH_SOLVERS_FACTORS_BIRTH_PRIOR_FACTOR_H_

#include <ceres/sized_cost_function.h>

#include "solvers/factors/state.h"

namespace kinegraph {

// r = [(p - centre) / sigma_m; v / sigma_mps]                            [6]
//
// Block 0: state [p; v] [m, m/s] of a track's first frame. Every joint starts
// somewhere around the person's centre, with a walking or running person's
// speed. A constant-velocity chain is rank-deficient without it, and with it
// every problem has full rank, whatever was seen.
class BirthPriorFactor final
    : public ceres::SizedCostFunction<kStateSize, kStateSize> {
 public:
  // Sigmas > 0.
  BirthPriorFactor(const Eigen::Vector3d& centre, double sigma_m,
                   double sigma_mps);
  static ceres::CostFunction* Create(const Eigen::Vector3d& centre,
                                     double sigma_m, double sigma_mps) {
    return new BirthPriorFactor(centre, sigma_m, sigma_mps);
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  Eigen::Vector3d centre_;
  double per_m_;
  double per_mps_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FACTORS_BIRTH_PRIOR_FACTOR_H_
