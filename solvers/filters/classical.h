// The classical filters that have no model of motion, on uniform or uneven
// time.
#ifndef KINEGRAPH_SOLVERS_FILTERS_CLASSICAL_H_
#define KINEGRAPH_SOLVERS_FILTERS_CLASSICAL_H_

#include <cstdint>
#include <functional>
#include <vector>

#include "solvers/filters/cutoff.h"
#include "solvers/filters/joint_segment.h"
#include "solvers/filters/options.h"

namespace kinegraph {

// Mean of the values weighted by exp(-dt^2 / (2 sigma^2)), over those within
// four sigmas (Nadaraya 1964, Watson 1964). Time need not be uniform; at the
// ends the weights are those of the values there are.
Samples CentredGaussian(double sigma_s, const std::vector<double>& times_s,
                        const Samples& values);

// Exponential smoothing whose cut-off grows with the smoothed speed (Casiez,
// Roussel and Vogel, CHI 2012, algorithm 1), column by column, by the real time
// between two values. The first value passes. The speed is that from the last
// filtered value to the new raw one, as in the paper; the authors' programs
// took the last raw value until August 2023. With zero phase the result runs
// through the filter once more, backwards.
Samples OneEuro(const OneEuroOptions& options,
                const std::vector<double>& times_s, const Samples& values);

// The odd number of frames nearest to the window, at least order + 1.
int SavitzkyGolayLength(const SavitzkyGolayOptions& options, double rate_hz);

// Each value becomes that of the polynomial of `order` >= 0 fitted by least
// squares to the `length` (odd, > order) values around it (Savitzky and Golay
// 1964); the first and last (length - 1) / 2 take theirs from the first and
// last full window, as scipy.signal.savgol_filter(mode='interp'). Fewer values
// than `length`: one polynomial through all of them, of at most one order less
// than there are.
Samples SavitzkyGolay(int length, int order, const Samples& values);

// Median over the window (Tukey 1977), column by column.
Samples MovingMedian(double window_s, WindowSide side,
                     const std::vector<double>& times_s, const Samples& values);

// Replaces a value by the median m of its window when it is farther from it
// than `threshold` standard deviations, estimated as 1.4826 median |x - m|
// (Hampel 1974; Davies and Gather 1993; Pearson 2002). All decisions are made
// on the values given, none on replaced ones. Column by column.
Samples HampelFilter(double window_s, double threshold, WindowSide side,
                     const std::vector<double>& times_s, const Samples& values);

// First the one, then the other.
Samples HampelMedian(const HampelMedianOptions& options,
                     const std::vector<double>& times_s, const Samples& values);

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

// Differences from value to value, filtered and summed up again; the sum has
// the mean of the values.
Samples OnSpeed(const std::function<Samples(const Samples&)>& filter,
                const Samples& values);

// Two passes of ButterworthLowPass, padded by scipy's rule, on what
// `options.on` names; `options.choice` and `options.cutoff_hz` are left to the
// caller of the low-pass.
LowPass ZeroPhaseButterworth(const ButterworthOptions& options, double rate_hz);

// The same with all poles at one real frequency, so that nothing overshoots
// (Robertson and Dowling, J. Electromyogr. Kinesiol. 13, 569, 2003): the power
// of both passes is 1 / (1 + r^2)^(2 order), r the ratio of analogue
// frequencies.
LowPass ZeroPhaseCriticallyDamped(const ButterworthOptions& options,
                                  double rate_hz);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FILTERS_CLASSICAL_H_
