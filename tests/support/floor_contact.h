// A user's own factor, as examples/own_factor.cc shows it: a resting ankle
// stays on the floor z = 0.
#ifndef KINEGRAPH_TESTS_SUPPORT_FLOOR_CONTACT_H_
#define KINEGRAPH_TESTS_SUPPORT_FLOOR_CONTACT_H_

#include <ceres/sized_cost_function.h>

#include <algorithm>
#include <vector>

#include "solvers/ceres/user_factor.h"

namespace kinegraph::testing {

// r = [(z - height) / sigma_m; v / sigma_mps] of a state [p; v]: the joint is
// `height_m` above the floor and at rest.
class FloorContact final : public ceres::SizedCostFunction<4, 6> {
 public:
  FloorContact(double height_m, double sigma_m, double sigma_mps)
      : height_m_(height_m), per_m_(1 / sigma_m), per_mps_(1 / sigma_mps) {}

  bool Evaluate(double const* const* states, double* residuals,
                double** jacobians) const override {
    const double* state = states[0];
    residuals[0] = per_m_ * (state[2] - height_m_);
    for (int i = 0; i < 3; ++i) residuals[i + 1] = per_mps_ * state[i + 3];
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    std::fill(jacobians[0], jacobians[0] + 24, 0.0);  // row by row
    jacobians[0][2] = per_m_;
    for (int i = 0; i < 3; ++i) jacobians[0][6 * (i + 1) + i + 3] = per_mps_;
    return true;
  }

 private:
  double height_m_, per_m_, per_mps_;
};

// The named joint rests in frames first .. last.
inline UserFactorSource Resting(const char* joint, int64_t first, int64_t last,
                                double height_m) {
  return [=](const UserFrame& frame) {
    std::vector<UserFactor> factors;
    if (frame.frame < first || frame.frame > last) return factors;
    UserFactor contact;
    contact.factor = FromCeres(new FloorContact(height_m, 0.005, 0.05));
    contact.states = {{frame.skeleton->IndexOf(joint), 0}};
    contact.loss = LossKind::kHuber;  // a wrong contact pulls, but gives way
    contact.loss_scale = 3.0;
    factors.push_back(contact);
    return factors;
  };
}

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_SUPPORT_FLOOR_CONTACT_H_
