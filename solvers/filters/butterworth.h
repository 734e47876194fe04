// Zero-phase Butterworth low-pass filter.
#ifndef KINEGRAPH_SOLVERS_FILTERS_BUTTERWORTH_H_
#define KINEGRAPH_SOLVERS_FILTERS_BUTTERWORTH_H_

#include <cstdint>
#include <vector>

#include "solvers/filters/joint_segment.h"
#include "solvers/filters/options.h"

namespace kinegraph {

// (b0 + b1 z^-1 + b2 z^-2) / (1 + a1 z^-1 + a2 z^-2).
struct FilterSection {
  double b0 = 1.0;
  double b1 = 0.0;
  double b2 = 0.0;
  double a1 = 0.0;
  double a2 = 0.0;
};

// Digital low-pass of `order` >= 1 by the bilinear transform with prewarping
// (Butterworth 1930; Oppenheim and Schafer, Discrete-Time Signal Processing,
// section 7.1): half the power at `cutoff_hz`, 0 < cutoff_hz < rate_hz / 2.
// Sections of order two, for odd orders a last one of order one; each passes a
// constant unchanged.
std::vector<FilterSection> ButterworthLowPass(int order, double cutoff_hz,
                                              double rate_hz);

// The cut-off to design each of two passes of `order` with, so that together
// they have half the power at `cutoff_hz` (Winter, Biomechanics and Motor
// Control of Human Movement, 4th ed., section 3.4.4.2: 0.802 for order 2), by
// the prewarped, thus exact, frequency.
double TwoPassCutoff(int order, double cutoff_hz, double rate_hz);

// Forwards, then backwards: no phase, the squared magnitude. The ends are
// continued by `padding` samples of odd reflection, 2 x(0) - x(k), at most one
// less than there are, and each pass starts as if the first value had always
// been (Gustafsson 1996; as scipy.signal.filtfilt does, whose padding for one
// filter of order n is 3 (n + 1)).
Samples FiltFilt(const std::vector<FilterSection>& sections,
                 const Samples& values, int padding);

// Residual analysis (Winter, section 3.4.4.3), made a rule: the root mean
// square R of what a cut-off takes away, all columns together, falls on a
// straight line over the cut-off where only noise is left to take. The line is
// fitted to the cut-offs from one quarter to 0.45 of the rate; its value at
// zero is the noise, and the answer is the lowest cut-off whose R is not above
// it, between candidates by interpolation. Candidates: every hundredth of the
// rate up to 0.45 of it. [Hz]
double ResidualAnalysisCutoff(const ButterworthOptions& options, double rate_hz,
                              const Samples& values);

// The whole of it: choice of the cut-off, correction, and padding by scipy's
// rule.
Samples ZeroPhaseButterworth(const ButterworthOptions& options, double rate_hz,
                             const Samples& values);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FILTERS_BUTTERWORTH_H_
