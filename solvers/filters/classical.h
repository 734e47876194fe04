// Classical filters without a motion model. Functions without `times_s` assume
// uniform time.
#ifndef KINEGRAPH_SOLVERS_FILTERS_CLASSICAL_H_
#define KINEGRAPH_SOLVERS_FILTERS_CLASSICAL_H_

#include <vector>

#include "solvers/filters/cutoff.h"
#include "solvers/filters/joint_segment.h"
#include "solvers/filters/options.h"

namespace kinegraph {

// Mean of the values weighted by exp(-dt^2 / (2 sigma^2)), over those within
// four sigmas (Nadaraya 1964, Watson 1964). Time may be non-uniform; at the
// ends only the existing values are weighted.
Samples CentredGaussian(double sigma_s, const std::vector<double>& times_s,
                        const Samples& values);

// Exponential smoothing whose cut-off grows with the smoothed speed (Casiez,
// Roussel and Vogel, CHI 2012, algorithm 1), column by column, by the actual
// time between two values. The first value is unchanged. The speed is computed
// from the last filtered value to the new raw value, as in the paper; the
// authors' programs used the last raw value until August 2023. With zero phase
// the result is filtered once more, backwards.
Samples OneEuro(const OneEuroOptions& options,
                const std::vector<double>& times_s, const Samples& values);

// The odd number of frames nearest to the window, at least order + 1.
int SavitzkyGolayLength(const SavitzkyGolayOptions& options, double rate_hz);

// Replaces each value by the value of the polynomial of `order` >= 0 fitted by
// least squares to the `length` (odd, > order) values around it (Savitzky and
// Golay 1964); the first and last (length - 1) / 2 values use the first and
// last full window, as in scipy.signal.savgol_filter(mode='interp'). If there
// are fewer values than `length`, one polynomial is fitted to all of them, of
// an order below their number.
Samples SavitzkyGolay(int length, int order, const Samples& values);

// Median over the window (Tukey 1977), column by column.
Samples MovingMedian(double window_s, WindowSide side,
                     const std::vector<double>& times_s, const Samples& values);

// Replaces a value by the median m of its window if their distance exceeds
// `threshold` standard deviations, estimated as 1.4826 median |x - m| (Hampel
// 1974; Davies and Gather 1993; Pearson 2002). All decisions use the original
// values, never replaced ones. Column by column.
Samples HampelFilter(double window_s, double threshold, WindowSide side,
                     const std::vector<double>& times_s, const Samples& values);

// The Hampel filter followed by the moving median.
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
// Sections of order two, followed by one of order one if `order` is odd; each
// passes a constant unchanged.
std::vector<FilterSection> ButterworthLowPass(int order, double cutoff_hz,
                                              double rate_hz);

// The cut-off with which to design each of two passes of `order`, so that
// together they have half the power at `cutoff_hz` (Winter, Biomechanics and
// Motor Control of Human Movement, 4th ed., section 3.4.4.2: 0.802 for order
// 2). Computed from the prewarped frequency and therefore exact.
double TwoPassCutoff(int order, double cutoff_hz, double rate_hz);

// Filters forwards, then backwards: no phase shift, squared gain. The ends are
// continued by odd reflection, 2 x(0) - x(k), over `padding` steps (at most the
// number of values minus one), and each pass starts in steady state for its
// first value (Gustafsson 1996; as in scipy.signal.filtfilt, whose padding for
// one filter of order n is 3 (n + 1)). A single value is unchanged.
Samples FiltFilt(const std::vector<FilterSection>& sections,
                 const Samples& values, int padding);

// Two passes of ButterworthLowPass, padded by scipy's rule, applied to the
// signal that `options.on` selects. Ignores `options.choice` and
// `options.cutoff_hz`: the caller of the low-pass sets the cut-off.
LowPass ZeroPhaseButterworth(const ButterworthOptions& options, double rate_hz);

// Like ZeroPhaseButterworth, with all poles at one real frequency instead, so
// that there is no overshoot (Robertson and Dowling, J. Electromyogr. Kinesiol.
// 13, 569, 2003): the power of both passes is 1 / (1 + r^2)^(2 order), r the
// ratio of the analogue frequency to that of the poles.
LowPass ZeroPhaseCriticallyDamped(const ButterworthOptions& options,
                                  double rate_hz);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FILTERS_CLASSICAL_H_
