#include "solvers/filters/one_euro.h"

#include <cmath>

namespace kinegraph {
namespace {

// Share of the new value in exponential smoothing with that cut-off.
double Alpha(double step_s, double cutoff_hz) {
  const double ratio = 2.0 * M_PI * cutoff_hz * step_s;
  return ratio / (ratio + 1.0);
}

}  // namespace

Samples OneEuro(const OneEuroOptions& options,
                const std::vector<double>& times_s, const Samples& values) {
  constexpr double kSpeedCutoff_hz = 1.0;  // the paper's
  Samples filtered = values;
  for (Eigen::Index c = 0; c < values.cols(); ++c) {
    double speed = 0.0;
    for (Eigen::Index i = 1; i < values.rows(); ++i) {
      const size_t k = static_cast<size_t>(i);
      const double step_s = times_s[k] - times_s[k - 1];
      const double last = filtered(i - 1, c);
      const double raw_speed = (values(i, c) - last) / step_s;
      speed += Alpha(step_s, kSpeedCutoff_hz) * (raw_speed - speed);
      const double cutoff_hz =
          options.min_cutoff_hz + options.beta_per_m * std::abs(speed);
      filtered(i, c) = last + Alpha(step_s, cutoff_hz) * (values(i, c) - last);
    }
  }
  return filtered;
}

}  // namespace kinegraph
