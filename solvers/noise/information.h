// What lasting errors cost a smoother that takes them for white, and how far it
// lags behind the motion.
#ifndef KINEGRAPH_SOLVERS_NOISE_INFORMATION_H_
#define KINEGRAPH_SOLVERS_NOISE_INFORMATION_H_

#include <Eigen/Core>
#include <vector>

#include "solvers/noise/pixel_noise.h"

namespace kinegraph {

// For points of variance R = `variance_m2` every h = `frame_s`, smoothed with
// process noise q = `process_noise` [m^2/s^3].
//
// A position that white noise of power q on its acceleration drives has the
// power spectrum q / w^4. A point's error is white but for a share a of its
// variance that decays as exp(-t / tau); sampled every h, its spectrum is R h
// S(w), where S sums the autocovariance (1 - a) [k = 0] + a phi^|k|, phi =
// exp(-h / tau), over all lags k:
//   S(w) = (1 - a) + a (1 - phi^2) / (1 + phi^2 - 2 phi cos(w h)).
// A smoother that takes the errors for white with the power R h S0 is, far from
// the ends, the Wiener filter of both spectra,
//   H(w) = (q / w^4) / (q / w^4 + R h S0) = 1 / (1 + (w / w_c)^4),
//   w_c^4 = q / (R h S0).
// Below the crossover w_c it follows its points, above it follows the motion
// prior: what the errors do near w_c decides, so S0 = S(w_c), which makes w_c a
// fixed point. The information of each observation is divided by S(w_c); the
// divisor is held at 1 or more. `near` is what was found for nearly the same
// noise (0: nothing), from which fewer rounds are enough.
double InformationDivisor(const ErrorCorrelation& correlation, double frame_s,
                          double process_noise, double variance_m2,
                          double near = 0.0);

// Factor on the covariances that the smoother then states, since the divisor
// is right at the crossover only. The error of the smoothed position is what H
// passes of the points' errors and what 1 - H keeps back of the motion, which
// are independent: its variance is the integral over w of
//   H^2 R h S(w) + (1 - H)^2 q / w^4.
// The smoother states the same integral with S(w_c) in place of S(w); the
// factor is the ratio of the two.
double CovarianceFactor(const ErrorCorrelation& correlation, double frame_s,
                        double process_noise, double variance_m2);

// Of that factor this is lag, whatever the errors: where the lag's variance is
// m times what the prior says, the factor is larger by (m - 1) times it. The
// integrals of H^2 and (1 - H)^2 / u^4 over u are as 3 to 1.
inline constexpr double kLagShare = 0.25;

// What the same smoother leaves of its points, and then passes of that: H (1 -
// H) of both spectra.
struct Leftover {
  double divisor = 1.0;      // of information, as above
  double independent = 0.0;  // values a frame, of three axes
  // Variances of an axis: of noise, and of lag if its variance is what the
  // prior says. Lag above the crossover cannot be told from noise, so how it
  // falls off there has to be said: as white jerk does, q / w^6, since people
  // move smoothly (Flash and Hogan 1985).
  double noise_m2 = 0.0;
  double lag_m2 = 0.0;
  // The same of what it leaves at first: (1 - H) of both.
  double first_noise_m2 = 0.0;
  double first_lag_m2 = 0.0;
};
Leftover LeftOver(const ErrorCorrelation& correlation, double frame_s,
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
  // At the nearest entry: variances to 2 %, in the mean of many right.
  Leftover LeftoverAt(double process_noise, double variance_m2);

 private:
  struct Knot {
    bool known = false;
    bool divided = false;  // the divisor is above 1
    double factor = 1.0;
    Leftover leftover;  // of a variance of 1
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

// One joint in one frame.
struct LagSample {
  double time_s = 0.0;
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();  // NaN: none
  double variance_m2 = 0.0;                           // of an axis of the point
  double process_noise = 0.0;  // since the sample before [m^2/s^3]
  Leftover expected;           // of this variance and process noise
};

// How far the smoother lags behind the motion, and how far off the points are,
// by the points that it smooths.
// Its prior, white acceleration, moves joints at any frequency; people hardly
// do above some Hertz, and then the lag that covariances reckon with is not
// there. What it leaves of its points, smoothed once more, is lag and little
// noise, since below its crossover it has followed the noise.
class LagLearner {
 public:
  // All samples of a joint, in the order of time.
  void Add(const std::vector<LagSample>& samples);

  // Variances of the points' errors and of the lag over what is expected of
  // them; 1 where little was seen.
  struct Ratios {
    double noise = 1.0;
    double lag = 1.0;
  };
  Ratios Fit() const;

 private:
  double count_ = 0.0;  // of independent values
  // What was left at first over the noise that is expected of it, by sample.
  std::vector<float> first_;
  // Sums over independent values: what was left then over its lag, and what is
  // expected of the other in both.
  double first_lag_ = 0.0;
  double left_ = 0.0, left_noise_ = 0.0;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_NOISE_INFORMATION_H_
