// The factors of solvers/factors as Ceres wants them.
#ifndef KINEGRAPH_SOLVERS_CERES_CERES_FACTOR_H_
#define KINEGRAPH_SOLVERS_CERES_CERES_FACTOR_H_

#include <ceres/cost_function.h>
#include <ceres/sized_cost_function.h>

#include <utility>

#include "solvers/factors/jacobian.h"
#include "solvers/graph/problem.h"

namespace kinegraph {

// Any of them: a parameter block for each state that it sees.
template <typename Factor,
          typename Indices = std::make_index_sequence<Factor::kKeys>>
class CeresFactor;

template <typename Factor, size_t... kIndices>
class CeresFactor<Factor, std::index_sequence<kIndices...>> final
    : public ceres::SizedCostFunction<
          Factor::kResiduals, (static_cast<void>(kIndices), kStateSize)...> {
 public:
  explicit CeresFactor(const Factor& factor) : factor_(factor) {}

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const double* const states[] = {parameters[kIndices]...};
    if (jacobians == nullptr) {
      return factor_.Evaluate(states, residuals, nullptr);
    }
    typename Factor::Jacobian by_states[Factor::kKeys];
    if (!factor_.Evaluate(states, residuals, by_states)) return false;
    for (int key = 0; key < Factor::kKeys; ++key) {
      if (jacobians[key] == nullptr) continue;
      double* out = jacobians[key];  // row by row
      for (int row = 0; row < Factor::kResiduals; ++row) {
        for (int i = 0; i < kStateSize; ++i) *out++ = by_states[key](row, i);
      }
    }
    return true;
  }

 private:
  Factor factor_;
};

// The caller owns the result (a Ceres problem takes it).
template <typename Factor>
ceres::CostFunction* MakeCeresFactor(const Factor& factor) {
  return new CeresFactor<Factor>(factor);
}

// PersonPrior as a factor on the first states of all joints. `prior` outlives
// it.
class CeresPersonPrior final : public ceres::CostFunction {
 public:
  explicit CeresPersonPrior(const PersonPrior* prior);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const PersonPrior* prior_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_CERES_CERES_FACTOR_H_
