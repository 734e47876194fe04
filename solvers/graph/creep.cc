#include "solvers/graph/creep.h"

#include <cmath>

namespace kinegraph {

namespace {

double Dot(const PersonStates& a, const PersonStates& b) {
  double sum = 0.0;
  for (size_t j = 0; j < a.size(); ++j) {
    for (size_t k = 0; k < a[j].size(); ++k) sum += a[j][k].dot(b[j][k]);
  }
  return sum;
}

}  // namespace

double StepsToCome(const PersonStates& previous_step,
                   const PersonStates& step) {
  return StepsToCome(Dot(previous_step, previous_step), Dot(step, step),
                     Dot(previous_step, step));
}

double StepsToCome(double previous_squared, double squared, double product) {
  constexpr double kParallel = 0.9;  // cosine
  constexpr double kSlow = 0.3;      // faster needs no help
  constexpr double kMost = 0.95;     // 19 steps: more is a guess
  const double before = std::sqrt(previous_squared);
  const double now = std::sqrt(squared);
  if (!(before > 0.0) || !(now > 0.0)) return 0.0;
  if (product < kParallel * before * now) return 0.0;
  const double share = now / before;
  if (share < kSlow) return 0.0;
  const double capped = std::fmin(share, kMost);
  return capped / (1.0 - capped);
}

}  // namespace kinegraph
