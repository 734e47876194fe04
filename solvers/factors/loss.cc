#include "solvers/factors/loss.h"

#include <cmath>

namespace kinegraph {

const std::vector<std::string>& LossNames() {
  static const std::vector<std::string> kNames = {"none", "huber", "cauchy",
                                                  "geman_mcclure", "tukey"};
  return kNames;
}

LossValue EvaluateLoss(LossKind kind, double scale, double s) {
  const double c2 = scale * scale;
  switch (kind) {
    case LossKind::kNone:
      break;
    case LossKind::kHuber: {
      if (s <= c2) break;
      const double root = std::sqrt(s);
      const double weight = scale / root;
      return {2.0 * scale * root - c2, weight, -0.5 * weight / s};
    }
    case LossKind::kCauchy: {
      const double weight = 1.0 / (1.0 + s / c2);
      return {c2 * std::log1p(s / c2), weight, -weight * weight / c2};
    }
    case LossKind::kGemanMcClure: {
      const double share = c2 / (c2 + s);
      return {s * share, share * share, -2.0 * share * share / (c2 + s)};
    }
    case LossKind::kTukey: {
      if (s >= c2) return {c2 / 3.0, 0.0, 0.0};
      const double rest = 1.0 - s / c2;
      return {c2 / 3.0 * (1.0 - rest * rest * rest), rest * rest,
              -2.0 * rest / c2};
    }
  }
  return {s, 1.0, 0.0};
}

double InformationCorrection(LossKind kind, double scale) {
  // s = r'r is exponential with mean 2. d psi/d r = w I + 2 w' r r' has the
  // expectation E[w + s w'] I, and E[psi psi'] = E[s w^2] / 2 I. Midpoint rule;
  // the tail beyond s = 60 weighs 1e-13.
  constexpr int kSteps = 20000;
  constexpr double kEnd = 60.0;
  constexpr double kStep = kEnd / kSteps;
  double mean_weight = 0.0;
  double mean_slope = 0.0;
  double mean_square = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double s = (i + 0.5) * kStep;
    const double density = 0.5 * std::exp(-0.5 * s) * kStep;
    const LossValue loss = EvaluateLoss(kind, scale, s);
    mean_weight += density * loss.first;
    mean_slope += density * (loss.first + s * loss.second);
    mean_square += density * 0.5 * s * loss.first * loss.first;
  }
  return mean_slope * mean_slope / mean_square / mean_weight;
}

}  // namespace kinegraph
