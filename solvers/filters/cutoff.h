// Rules that choose the cut-off of a low-pass from the signal.
#ifndef KINEGRAPH_SOLVERS_FILTERS_CUTOFF_H_
#define KINEGRAPH_SOLVERS_FILTERS_CUTOFF_H_

#include <functional>
#include <vector>

#include "solvers/filters/joint_segment.h"
#include "solvers/filters/options.h"

namespace kinegraph {

// A low-pass whose cut-off is open.
struct LowPass {
  double rate_hz = 0.0;
  std::function<Samples(double cutoff_hz, const Samples& values)> filter;
  // What is left of the amplitude of a wave, far from the ends.
  std::function<double(double frequency_hz, double cutoff_hz)> gain;
};

// By residuals R(f), the root mean square of what a cut-off f takes from the
// values, all columns together, at every hundredth of the rate up to 0.45 of
// it:
// - kWinter (Biomechanics and Motor Control of Human Movement, 4th ed., section
//   3.4.4.3), made a rule: where only noise is left to take, R falls on a
//   straight line over f; it is fitted from one quarter to 0.45 of the rate,
//   its value at zero is the noise, and the answer is the lowest f whose R is
//   not above it, between candidates by interpolation.
// - kJackson (IEEE Trans. Biomed. Eng. 26, 122, 1979): the first f after the
//   bend of R where its second difference is below a limit. The paper leaves
//   the limit open; here 5 % of the greatest.
// - kGcv (Craven and Wahba 1979): least R^2 / (1 - mean gain)^2.
// By autocorrelation:
// - kChallis (J. Appl. Biomech. 15, 303, 1999): the f whose residual is most
//   like white noise, of least sum of |autocorrelation| over all lags, at every
//   two hundredth of the rate up to one quarter of it.
// By regression:
// - kYu (Yu et al., J. Appl. Biomech. 15, 318, 1999): 0.06 r - 0.000022 r^2 +
//   5.95 / e, r the rate [Hz], e [%] the residual of the cut-off
//   0.071 r - 0.00003 r^2 over the signal's deviation from its mean.
// By power: the frequency below which 95 or 99 % of the power lie, of the
// values without their line of least squares, under Hann's window.
// All answers are between 0.01 and 0.45 of the rate. Fewer than ten values:
// 0.45 of it. Not kFixed or kLambda.
double ChooseCutoff(CutoffChoice rule, const LowPass& low_pass,
                    const Samples& values);

// One cut-off a column [Hz]: for each alone, or one for all.
std::vector<double> ChooseCutoffs(CutoffChoice rule, CutoffPer per,
                                  const LowPass& low_pass,
                                  const Samples& values);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FILTERS_CUTOFF_H_
