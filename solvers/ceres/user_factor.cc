#include "solvers/ceres/user_factor.h"

#include <ceres/cost_function.h>

#include <string>

#include "core/base/error.h"
#include "solvers/factors/jacobian.h"

namespace kinegraph {
namespace {

class CeresUserFactor final : public GeneralFactor {
 public:
  explicit CeresUserFactor(ceres::CostFunction* cost) : cost_(cost) {
    for (const int32_t size : cost_->parameter_block_sizes()) {
      if (size == kStateSize) continue;
      throw OptionError("user factor", "found a parameter block of size " +
                                           std::to_string(size) +
                                           ", expected a state of size " +
                                           std::to_string(kStateSize));
    }
  }

  int residual_count() const override { return cost_->num_residuals(); }
  int state_count() const override {
    return static_cast<int>(cost_->parameter_block_sizes().size());
  }
  bool Evaluate(double const* const* states, double* residuals,
                double** jacobians) const override {
    return cost_->Evaluate(states, residuals, jacobians);
  }

 private:
  const std::unique_ptr<ceres::CostFunction> cost_;
};

}  // namespace

std::shared_ptr<const GeneralFactor> FromCeres(ceres::CostFunction* cost) {
  return std::make_shared<const CeresUserFactor>(cost);
}

}  // namespace kinegraph
