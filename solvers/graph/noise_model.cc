#include "solvers/graph/noise_model.h"

#include <algorithm>
#include <cmath>

namespace kinegraph {

double TrustedConfidence(const GraphOptions& options, double confidence) {
  return std::min(1.0, std::max(options.min_confidence, confidence));
}

double PixelSigma(const GraphOptions& options, JointClass joint_class,
                  double confidence, double depth_m, double focal_px) {
  constexpr double kReferenceSize = 1000.0 / 4.0;  // px per metre
  const double trusted = TrustedConfidence(options, confidence);
  const double sigma_px = options.sigma_px[static_cast<int>(joint_class)] *
                          std::pow(trusted, -options.confidence_power) *
                          focal_px / depth_m / kReferenceSize;
  return std::max(options.min_sigma_px, sigma_px);
}

double InformationScale(const GraphOptions& options, double dt_s) {
  if (options.correlation_time_s <= 0.0) return options.information_scale;
  const double half = 0.5 * dt_s / options.correlation_time_s;
  // (1 - e^-2h) / (1 + e^-2h) = tanh h.
  return options.information_scale * std::tanh(half);
}

}  // namespace kinegraph
