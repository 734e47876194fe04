// Adapts the factors of solvers/factors to Ceres.
#ifndef KINEGRAPH_SOLVERS_CERES_CERES_FACTOR_H_
#define KINEGRAPH_SOLVERS_CERES_CERES_FACTOR_H_

#include <ceres/cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/sized_cost_function.h>

#include <utility>

#include "solvers/factors/jacobian.h"
#include "solvers/factors/loss.h"
#include "solvers/graph/factor_list.h"
#include "solvers/graph/problem.h"

namespace kinegraph {

// Adapts a factor of factor_list.h to Ceres: one parameter block per state.
template <typename Factor,
          typename Indices = std::make_index_sequence<Factor::kKeys>>
class CeresFactor;

template <typename Factor, size_t... kIndices>
class CeresFactor<Factor, std::index_sequence<kIndices...>> final
    : public ceres::SizedCostFunction<
          Factor::kResiduals, (static_cast<void>(kIndices), kStateSize)...> {
 public:
  CeresFactor() = default;  // Set() must follow
  explicit CeresFactor(const Factor& factor) : factor_(factor) {}

  // Replaces the factor between solves.
  void Set(const Factor& factor) { factor_ = factor; }

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

// PersonPrior as a factor on the first states of `joint_count` joints. The
// prior must be set before a solve and must outlive it.
class CeresPersonPrior final : public ceres::CostFunction {
 public:
  explicit CeresPersonPrior(size_t joint_count);

  void Set(const PersonPrior* prior) { prior_ = prior; }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const PersonPrior* prior_ = nullptr;
};

// The caller owns the result. Null for LossKind::kNone.
ceres::LossFunction* MakeCeresLoss(LossKind kind, double scale);

// The measurements of a joint in one frame as one residual block, because
// Ceres' overhead per block exceeds the cost of a projection. The robust loss
// is applied inside the block, per view: for a view's whitened residual r with
// s = r'r the block returns
//   r~ = sqrt(information rho(s) / s) r,
// so that 0.5 |r~|^2 is its cost, with the Jacobian
//   sqrt(information) [sqrt(rho') (I - r r'/s) + rho' / sqrt(rho / s) r r'/s]
//   J,
// with which the block has the true gradient information rho' J'r.
// Perpendicular to r this is iteratively reweighted least squares; along r an
// outlier has less curvature, as in the true cost, so that fewer steps are
// needed.
//
// Reads the measurements in place, so nothing is copied when a window advances.
// The three residuals of BodyCentre, which depends on the same state, come
// first, then two for each view that is not gated.
class ViewBundle final : public ceres::CostFunction {
 public:
  ViewBundle();

  // Selects the measurements of frame `k` and the loss of `stage`. All
  // arguments must outlive the solve, and gating must not change during it.
  void Set(const JointChain& chain, size_t k, const PersonCentre& centre,
           const SolveStage* stage);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const PixelMeasurement* begin_ = nullptr;
  const PixelMeasurement* end_ = nullptr;
  BodyCentre<double> centre_;
  const SolveStage* stage_ = nullptr;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_CERES_CERES_FACTOR_H_
