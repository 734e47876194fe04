// What lasting errors cost a smoother that takes them for white.
#ifndef KINEGRAPH_SOLVERS_NOISE_INFORMATION_H_
#define KINEGRAPH_SOLVERS_NOISE_INFORMATION_H_

#include <vector>

#include "solvers/noise/pixel_noise.h"

namespace kinegraph {

// For points of variance `variance_m2` every `frame_s`, smoothed with process
// noise `process_noise` [m^2/s^3]. The errors' power at frequency w, over that
// of white ones, is
//   S(w) = (1 - a) + a (1 - phi^2) / (1 + phi^2 - 2 phi cos(w h)),
// phi = exp(-h / tau). The smoother passes H(w) = 1 / (1 + (w / w_c)^4) with
// w_c^4 = q / (R h S(w_c)). Its information of each observation is divided by
// S(w_c), 1 or more.
double InformationDivisor(const ErrorCorrelation& correlation, double frame_s,
                          double process_noise, double variance_m2);

// Factor on the covariances that the smoother then states, since the divisor
// is right at the crossover only: the integral of
//   H^2 R h S(w) + (1 - H)^2 q / w^4
// over w, divided by the same with S(w_c) in place of S(w).
double CovarianceFactor(const ErrorCorrelation& correlation, double frame_s,
                        double process_noise, double variance_m2);

// CovarianceFactor for one kind of errors and one time between frames. It
// depends on process_noise / variance_m2 alone: a table over the logarithm,
// filled as it is asked, gives it to 1e-5 by cubic interpolation, and as it is
// where the divisor comes down to 1, which is a bend, and beyond the table.
class CovarianceFactorTable {
 public:
  CovarianceFactorTable(const ErrorCorrelation& correlation, double frame_s);

  double frame_s() const { return frame_s_; }
  double At(double process_noise, double variance_m2);

 private:
  struct Knot {
    bool known = false;
    bool divided = false;  // the divisor is above 1
    double factor = 1.0;
  };
  const Knot& KnotAt(size_t i);

  ErrorCorrelation correlation_;
  double frame_s_;
  std::vector<Knot> knots_;
};

// The process noise [m^2/s^3] whose crossover w_c, as above, is at
// `frequency_hz`: a smoother with less of it passes only what is slower.
double ProcessNoiseOfCrossover(const ErrorCorrelation& correlation,
                               double frame_s, double variance_m2,
                               double frequency_hz);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_NOISE_INFORMATION_H_
