#include "solvers/factors/loss.h"

#include <cmath>
#include <map>
#include <mutex>
#include <utility>

namespace kinegraph {

const std::vector<std::string>& LossNames() {
  static const std::vector<std::string> kNames = {"none", "huber", "cauchy",
                                                  "geman_mcclure", "tukey"};
  return kNames;
}

LossValue EvaluateLoss(LossKind kind, double scale, double s) {
  return LossAt(kind, scale, s);
}

namespace {

double IntegrateCorrection(LossKind kind, double scale) {
  // s = r'r is exponential with mean 2. d psi/d r = w I + 2 w' r r' has the
  // expectation E[w + s w'] I, and E[psi psi'] = E[s w^2] / 2 I. Midpoint rule;
  // the tail beyond s = 60 has a weight of 1e-13.
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

}  // namespace

double InformationCorrection(LossKind kind, double scale) {
  // Cached: a run evaluates few different losses, each many times.
  static std::mutex mutex;
  static std::map<std::pair<LossKind, double>, double> known;
  const std::lock_guard<std::mutex> lock(mutex);
  const auto [at, is_new] = known.try_emplace({kind, scale}, 0.0);
  if (is_new) at->second = IntegrateCorrection(kind, scale);
  return at->second;
}

}  // namespace kinegraph
