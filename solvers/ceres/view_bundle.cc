#include "solvers/ceres/view_bundle.h"

#include <cmath>
#include <utility>

namespace kinegraph {
namespace {

// Factors of a robust residual: of r itself, and of J across and along r.
struct Roots {
  double residual = 1.0;
  double across = 1.0;
  double along = 1.0;
};

Roots RootsOf(const Robustness& robustness, double s) {
  const double root = std::sqrt(robustness.information);
  constexpr double kTiny = 1e-12;  // all losses are s + O(s^2)
  if (s < kTiny) return {root, root, root};
  const LossValue loss = robustness.Evaluate(s);
  const double share = std::sqrt(loss.rho / s);
  return {root * share, root * std::sqrt(loss.first),
          root * loss.first / share};
}

}  // namespace

ViewBundle::ViewBundle(std::vector<View> views) : views_(std::move(views)) {
  set_num_residuals(CameraReprojection::kResiduals *
                    static_cast<int>(views_.size()));
  mutable_parameter_block_sizes()->assign(1, kStateSize);
}

bool ViewBundle::Evaluate(double const* const* parameters, double* residuals,
                          double** jacobians) const {
  const double* const states[] = {parameters[0]};
  double* out = jacobians == nullptr ? nullptr : jacobians[0];
  for (const View& view : views_) {
    double r[2];
    PointJacobian<2, double> by_state;
    if (!view.factor.Evaluate(states, r,
                              out == nullptr ? nullptr : &by_state)) {
      return false;
    }
    const double s = r[0] * r[0] + r[1] * r[1];
    const Roots roots = RootsOf(view.robustness, s);
    *residuals++ = roots.residual * r[0];
    *residuals++ = roots.residual * r[1];
    if (out == nullptr) continue;
    const double turn = s > 0.0 ? (roots.along - roots.across) / s : 0.0;
    for (int i = 0; i < kStateSize; ++i) {
      const double inward = r[0] * by_state(0, i) + r[1] * by_state(1, i);
      out[i] = roots.across * by_state(0, i) + turn * inward * r[0];
      out[kStateSize + i] =
          roots.across * by_state(1, i) + turn * inward * r[1];
    }
    out += 2 * kStateSize;
  }
  return true;
}

}  // namespace kinegraph
