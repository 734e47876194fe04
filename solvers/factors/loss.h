// Robust losses by name, independent of any solver.
//
// A loss rho turns the squared norm s of a whitened residual (dimensionless)
// into a cost 0.5 rho(s). All have rho(s) = s + O(s^2) near zero, so `scale` c
// is in sigmas:
//   none           s
//   huber          s up to c^2, then 2 c sqrt(s) - c^2
//   cauchy         c^2 log(1 + s / c^2)
//   geman_mcclure  c^2 s / (c^2 + s)
//   tukey          c^2 / 3 (1 - (1 - s / c^2)^3) up to c^2, then c^2 / 3
#ifndef KINEGRAPH_SOLVERS_FACTORS_LOSS_H_
#define KINEGRAPH_SOLVERS_FACTORS_LOSS_H_

#include <string>
#include <vector>

#include "solvers/factors/robust_loss.h"

namespace kinegraph {

// Names in the order of the enum.
const std::vector<std::string>& LossNames();

using LossValue = LossTerms<double>;

// `scale` > 0 [sigmas], `s` >= 0.
LossValue EvaluateLoss(LossKind kind, double scale, double s);

// A non-convex loss started far from the minimum can exclude good observations
// permanently; it needs a schedule that begins with a convex loss.
inline bool IsConvex(LossKind kind) {
  return kind == LossKind::kNone || kind == LossKind::kHuber;
}

// The actual information of one observation under a loss, divided by the weight
// that the loss assigns: for 2-vectors r ~ N(0, I), w = rho'(r'r), psi = w r,
//   [E dpsi/dr]^2 / E[psi psi'] / E[w]
// (the sandwich formula of M-estimators, Huber and Ronchetti, Robust
// Statistics, ch. 6, divided by J'WJ). 1 for no loss; above 1 for redescending
// losses, whose J'WJ is too small.
double InformationCorrection(LossKind kind, double scale);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FACTORS_LOSS_H_
