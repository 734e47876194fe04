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

void OneEuroOptions::Describe(OptionVisitor& visitor) {
  visitor.Number("min_cutoff", &min_cutoff_hz, Positive(), "Hz", "at rest");
  visitor.Number("beta", &beta_per_m, NonNegative(), "1/m",
                 "the cut-off grows by so many Hz per m/s");
  visitor.Number("derivative_cutoff", &derivative_cutoff_hz, Positive(), "Hz",
                 "of the speed");
}

Samples OneEuro(const OneEuroOptions& options,
                const std::vector<double>& times_s, const Samples& values) {
  Samples filtered = values;
  for (Eigen::Index c = 0; c < values.cols(); ++c) {
    double speed = 0.0;
    for (Eigen::Index i = 1; i < values.rows(); ++i) {
      const size_t k = static_cast<size_t>(i);
      const double step_s = times_s[k] - times_s[k - 1];
      const double last = filtered(i - 1, c);
      const double raw_speed = (values(i, c) - last) / step_s;
      speed +=
          Alpha(step_s, options.derivative_cutoff_hz) * (raw_speed - speed);
      const double cutoff_hz =
          options.min_cutoff_hz + options.beta_per_m * std::abs(speed);
      filtered(i, c) = last + Alpha(step_s, cutoff_hz) * (values(i, c) - last);
    }
  }
  return filtered;
}

}  // namespace kinegraph
