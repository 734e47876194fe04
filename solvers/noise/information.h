// What lasting errors cost a smoother that takes them for white.
#ifndef KINEGRAPH_SOLVERS_NOISE_INFORMATION_H_
#define KINEGRAPH_SOLVERS_NOISE_INFORMATION_H_

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

// The process noise [m^2/s^3] whose crossover w_c, as above, is at
// `frequency_hz`: a smoother with less of it passes only what is slower.
double ProcessNoiseOfCrossover(const ErrorCorrelation& correlation,
                               double frame_s, double variance_m2,
                               double frequency_hz);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_NOISE_INFORMATION_H_
