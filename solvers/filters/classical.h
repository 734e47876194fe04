// The classical filters that have no model of motion, on uniform or uneven
// time.
#ifndef KINEGRAPH_SOLVERS_FILTERS_CLASSICAL_H_
#define KINEGRAPH_SOLVERS_FILTERS_CLASSICAL_H_

#include <vector>

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
// took the last raw value until August 2023.
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

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FILTERS_CLASSICAL_H_
