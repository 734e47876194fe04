#include "solvers/noise/chi_square.h"

#include <cmath>

namespace kinegraph {
namespace {

// The regularised incomplete gamma function P(a, x) by its series (Abramowitz
// and Stegun 6.5.29). It converges for every x; the quantiles asked for are
// near a.
double GammaShare(double a, double x) {
  if (x <= 0.0) return 0.0;
  double term = 1.0 / a;
  double sum = term;
  for (double n = a + 1.0; term > 1e-17 * sum; n += 1.0) {
    term *= x / n;
    sum += term;
  }
  return sum * std::exp(a * std::log(x) - x - std::lgamma(a));
}

}  // namespace

double ChiSquareQuantile(double share, double degrees_of_freedom) {
  const double a = 0.5 * degrees_of_freedom;
  double low = 0.0;
  double high = a + 1.0;
  while (GammaShare(a, high) < share) high *= 2.0;
  // Sixty halvings: the width of a double's digits.
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (GammaShare(a, middle) < share ? low : high) = middle;
  }
  return low + high;  // twice the middle: chi-square is twice gamma
}

}  // namespace kinegraph
