// How much information a smoother that assumes white errors loses if they are
// correlated, and how far it lags behind the motion.
#ifndef KINEGRAPH_SOLVERS_NOISE_INFORMATION_H_
#define KINEGRAPH_SOLVERS_NOISE_INFORMATION_H_

#include <Eigen/Core>
#include <vector>

#include "solvers/noise/learnt_noise.h"

namespace kinegraph {

// For points of variance R = `variance_m2` every h = `frame_s`, smoothed with
// process noise q = `process_noise` [m^2/s^3].
//
// A position driven by white noise of power q on its acceleration has the power
// spectrum q / w^4. A point's error is white except for a share a of its
// variance that decays as exp(-t / tau); sampled every h, its spectrum is R h
// S(w), where S sums the autocovariance (1 - a) [k = 0] + a phi^|k|, phi =
// exp(-h / tau), over all lags k:
//   S(w) = (1 - a) + a (1 - phi^2) / (1 + phi^2 - 2 phi cos(w h)).
// A smoother that assumes white errors of power R h S0 is, far from the ends,
// the Wiener filter of both spectra,
//   H(w) = (q / w^4) / (q / w^4 + R h S0) = 1 / (1 + (w / w_c)^4),
//   w_c^4 = q / (R h S0).
// Below the crossover w_c it follows its points, above it the motion prior.
// Errors near w_c matter most, so S0 = S(w_c), which makes w_c a fixed point.
// The information of each observation is divided by S(w_c); the divisor is at
// least 1. `near`: a starting value for the fixed-point iteration, such as the
// divisor that an earlier call returned for the same frame (0: none).
double InformationDivisor(const ErrorCorrelation& correlation, double frame_s,
                          double process_noise, double variance_m2,
                          double near = 0.0);

// Factor of the covariances that the smoother then reports, because the divisor
// is exact at the crossover only. The error of the smoothed position is the
// part of the points' errors that H passes plus the part of the motion that 1 -
// H removes, which are independent: its variance is the integral over w of
//   H^2 R h S(w) + (1 - H)^2 q / w^4.
// The smoother reports the same integral with S(w_c) in place of S(w); the
// factor is the ratio of the two.
double CovarianceFactor(const ErrorCorrelation& correlation, double frame_s,
                        double process_noise, double variance_m2);

// The part of CovarianceFactor due to lag, for any errors: if the lag's
// variance is m times the prior's prediction, the factor grows by (m - 1) times
// this. The integrals of H^2 and (1 - H)^2 / u^4 over u have the ratio 3 to 1.
inline constexpr double kLagShare = 0.25;

// Expected variances of the residuals of the same smoother, smoothed once more:
// H (1 - H) applied to both spectra.
struct Leftover {
  double divisor = 1.0;      // InformationDivisor
  double independent = 0.0;  // independent values per frame, over three axes
  // Variances per axis of the noise, and of the lag if it is as the prior
  // predicts. Lag above the crossover cannot be distinguished from noise, so
  // its decay there is assumed to be that of white jerk, q / w^6, because
  // people move smoothly (Flash and Hogan 1985).
  double noise_m2 = 0.0;
  double lag_m2 = 0.0;
  // Variances of the residuals of the first pass: 1 - H applied to both
  // spectra.
  double first_noise_m2 = 0.0;
  double first_lag_m2 = 0.0;
};
Leftover LeftOver(const ErrorCorrelation& correlation, double frame_s,
                  double process_noise, double variance_m2);

// CovarianceFactor for one error correlation and one frame interval. It depends
// only on process_noise / variance_m2; a table over the logarithm of this
// ratio, filled on demand, gives it to 1e-5 by cubic interpolation. It is
// computed directly near the kink at which the divisor reaches 1, and outside
// the table.
class CovarianceFactorTable {
 public:
  CovarianceFactorTable(const ErrorCorrelation& correlation, double frame_s);

  double frame_s() const { return frame_s_; }
  double At(double process_noise, double variance_m2);
  // From the nearest table entry, without interpolation: variances are accurate
  // to 2 %.
  Leftover LeftoverAt(double process_noise, double variance_m2);

 private:
  struct Knot {
    bool known = false;
    bool divided = false;  // whether the divisor is above 1
    double factor = 1.0;
    Leftover leftover;  // for a variance of 1
  };
  const Knot& KnotAt(size_t i);

  ErrorCorrelation correlation_;
  double frame_s_;
  std::vector<Knot> knots_;
};

// The process noise [m^2/s^3] whose crossover w_c (see InformationDivisor) lies
// at `frequency_hz`. A smoother with less process noise passes only lower
// frequencies.
double ProcessNoiseOfCrossover(const ErrorCorrelation& correlation,
                               double frame_s, double variance_m2,
                               double frequency_hz);

// One joint in one frame.
struct LagSample {
  double time_s = 0.0;
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();  // NaN if missing
  double variance_m2 = 0.0;                           // of the point, per axis
  double process_noise = 0.0;  // since the previous sample [m^2/s^3]
  Leftover expected;           // for this variance and process noise
};

// Estimates the smoother's lag behind the motion, and the error of the points,
// from the points that it smooths. Its prior, white acceleration, assumes
// motion at all frequencies; people hardly move above a few hertz, so the lag
// assumed in covariances is absent there. The smoother's residuals, smoothed
// once more, are mostly lag, because below its crossover the smoother has
// followed the noise.
class LagLearner {
 public:
  // Adds all samples of a joint, in temporal order.
  void Add(const std::vector<LagSample>& samples);

  // Variances of the points' errors and of the lag relative to their
  // expectation; near 1 with few samples.
  struct Ratios {
    double noise = 1.0;
    double lag = 1.0;
  };
  Ratios Fit() const;

 private:
  double count_ = 0.0;  // number of independent values
  // Residuals of the first pass relative to their expected noise, by sample.
  std::vector<float> first_;
  // Weighted sums. First pass: expected lag / expected noise.
  double first_lag_ = 0.0;
  // Second pass: residual / expected lag, and expected noise / expected lag.
  double left_ = 0.0, left_noise_ = 0.0;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_NOISE_INFORMATION_H_
