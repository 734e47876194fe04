#include "solvers/noise/information.h"

#include <algorithm>
#include <cmath>

namespace kinegraph {
namespace {

constexpr double kPi = 3.14159265358979323846;

struct Spectrum {
  Spectrum(const ErrorCorrelation& correlation, double frame_s)
      : share(correlation.share),
        phi(std::exp(-frame_s / correlation.time_s)),
        h(frame_s) {}

  double operator()(double w) const {
    const double angle = std::min(kPi, w * h);
    return 1.0 - share +
           share * (1.0 - phi * phi) /
               (1.0 + phi * phi - 2.0 * phi * std::cos(angle));
  }

  double share;
  double phi;
  double h;
};

struct Crossover {
  double frequency = 0.0;  // rad/s
  double divisor = 1.0;
};

Crossover FindCrossover(const Spectrum& spectrum, double process_noise,
                        double variance_m2) {
  Crossover at;
  // Each round moves the crossover by a quarter of the divisor's change.
  for (int i = 0; i < 8; ++i) {
    at.frequency = std::sqrt(
        std::sqrt(process_noise / (variance_m2 * spectrum.h * at.divisor)));
    at.divisor = std::max(1.0, spectrum(at.frequency));
  }
  return at;
}

}  // namespace

double InformationDivisor(const ErrorCorrelation& correlation, double frame_s,
                          double process_noise, double variance_m2) {
  if (!(correlation.share > 0.0)) return 1.0;
  return FindCrossover(Spectrum(correlation, frame_s), process_noise,
                       variance_m2)
      .divisor;
}

double CovarianceFactor(const ErrorCorrelation& correlation, double frame_s,
                        double process_noise, double variance_m2) {
  if (!(correlation.share > 0.0)) return 1.0;
  const Spectrum spectrum(correlation, frame_s);
  const Crossover at = FindCrossover(spectrum, process_noise, variance_m2);
  // In units of R h S(w_c), over u = w / w_c, at midpoints.
  constexpr int kSteps = 48;
  constexpr double kEnd = 4.0;
  double true_power = 0.0;
  double stated_power = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double u = (i + 0.5) * kEnd / kSteps;
    const double u4 = u * u * u * u;
    const double passed = 1.0 / ((1.0 + u4) * (1.0 + u4));  // H^2
    const double lag = u4 * passed;                         // (1 - H)^2 / u^4
    true_power += passed * spectrum(u * at.frequency) / at.divisor + lag;
    stated_power += passed + lag;
  }
  return true_power / stated_power;
}

double ProcessNoiseOfCrossover(const ErrorCorrelation& correlation,
                               double frame_s, double variance_m2,
                               double frequency_hz) {
  const double w = 2.0 * kPi * frequency_hz;
  const double divisor =
      correlation.share > 0.0 ? Spectrum(correlation, frame_s)(w) : 1.0;
  return w * w * w * w * variance_m2 * frame_s * std::max(1.0, divisor);
}

}  // namespace kinegraph
