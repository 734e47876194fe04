// Rules that choose the cut-off of a low-pass from the signal.
#ifndef KINEGRAPH_SOLVERS_FILTERS_CUTOFF_H_
#define KINEGRAPH_SOLVERS_FILTERS_CUTOFF_H_

#include <functional>
#include <vector>

#include "solvers/filters/joint_segment.h"
#include "solvers/filters/options.h"

namespace kinegraph {

// A low-pass with a free cut-off.
struct LowPass {
  double rate_hz = 0.0;
  std::function<Samples(double cutoff_hz, const Samples& values)> filter;
  // Amplitude of a filtered sine of unit amplitude, far from the ends.
  std::function<double(double frequency_hz, double cutoff_hz)> gain;
};

// By the residual R(f): the root mean square over time of the part of the
// values that a cut-off f removes, the columns taken as one vector. The
// candidates f are every hundredth of the rate up to 0.45 of it.
// - kWinter (Biomechanics and Motor Control of Human Movement, 4th ed., section
//   3.4.4.3, without its choice by eye): where only noise is removed, R is a
//   straight line over f. The line is fitted from one quarter to 0.45 of the
//   rate, its value at zero is the noise, and the result is the lowest f whose
//   R does not exceed the noise, interpolated between candidates.
// - kJackson (IEEE Trans. Biomed. Eng. 26, 122, 1979): the first f after the
//   bend of R where its second difference is below a limit. The paper does not
//   specify the limit; here it is 5 % of the greatest second difference.
// - kGcv (Craven and Wahba 1979): least R^2 / (1 - mean gain)^2.
// By autocorrelation:
// - kChallis (J. Appl. Biomech. 15, 303, 1999): the f whose residual is most
//   like white noise, i.e. has the least sum of |autocorrelation| over all
//   lags, at multiples of 1/200 of the rate up to one quarter of it.
// By regression:
// - kYu (Yu et al., J. Appl. Biomech. 15, 318, 1999): 0.06 r - 0.000022 r^2 +
//   5.95 / e, r the rate [Hz], e [%] the residual of the cut-off
//   0.071 r - 0.00003 r^2 over the signal's deviation from its mean.
// By power: the frequency below which 95 or 99 % of the power lies, after
// removal of the least-squares line, under a Hann window. All results are
// clamped to 0.01 .. 0.45 of the rate; 0.45 of it for fewer than ten values.
// `rule` must not be kFixed or kLambda.
double ChooseCutoff(CutoffChoice rule, const LowPass& low_pass,
                    const Samples& values);

// One cut-off per column [Hz]: chosen for each column if `per` is kAxis, else
// the same for all columns.
std::vector<double> ChooseCutoffs(CutoffChoice rule, CutoffPer per,
                                  const LowPass& low_pass,
                                  const Samples& values);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FILTERS_CUTOFF_H_
