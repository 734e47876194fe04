#include "core/geometry/ball_probability.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/base/constants.h"

namespace kinegraph {
namespace {

// Gauss-Legendre rule with twelve points, on [0, 1].
template <typename Function>
double Integral(const Function& function) {
  constexpr double kNodes[] = {0.1252334085114689, 0.3678314989981802,
                               0.5873179542866175, 0.7699026741943047,
                               0.9041172563704749, 0.9815606342467193};
  constexpr double kWeights[] = {0.2491470458134028, 0.2334925365383548,
                                 0.2031674267230659, 0.1600783285433462,
                                 0.1069393259953184, 0.0471753363865118};
  double sum = 0.0;
  for (int i = 0; i < 6; ++i) {
    sum += 0.5 * kWeights[i] *
           (function(0.5 + 0.5 * kNodes[i]) + function(0.5 - 0.5 * kNodes[i]));
  }
  return sum;
}

// Integral of a Gaussian's density times `function` over -end .. end, where
// `function` is even; truncated at six sigmas. The substitution z = reach
// sin(angle) makes chord lengths smooth.
template <typename Function>
double Expected(double sigma, double end, const Function& function) {
  constexpr double kDensity = 0.3989422804014327;  // 1 / sqrt(2 pi)
  constexpr double kQuarter = 0.5 * kPi;
  const double reach = std::min(6.0, end / sigma);
  return 2.0 * reach * kDensity * kQuarter * Integral([&](double t) {
           const double z = reach * std::sin(kQuarter * t);
           return std::cos(kQuarter * t) * std::exp(-0.5 * z * z) *
                  function(z * sigma);
         });
}

}  // namespace

double ProbabilityWithin(double radius_m,
                         const Eigen::Matrix3d& covariance_m2) {
  constexpr double kLeastVariance = 1e-18;  // m^2: sigmas are divisors
  const Eigen::Vector3d sigma_m =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance_m2,
                                                     Eigen::EigenvaluesOnly)
          .eigenvalues()
          .cwiseMax(kLeastVariance)
          .cwiseSqrt();
  constexpr double kAll = 8.0;  // sigmas: less than 1e-13 lies outside
  if (radius_m > kAll * sigma_m[2]) return 1.0;
  const auto chord = [](double radius, double x) {
    return std::sqrt(std::max(0.0, radius * radius - x * x));
  };
  const double within = Expected(sigma_m[2], radius_m, [&](double x) {
    const double disc_m = chord(radius_m, x);
    return Expected(sigma_m[1], disc_m, [&](double y) {
      return std::erf(chord(disc_m, y) / (std::sqrt(2.0) * sigma_m[0]));
    });
  });
  return std::min(1.0, within);
}

}  // namespace kinegraph
