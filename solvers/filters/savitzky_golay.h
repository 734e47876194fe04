// Savitzky-Golay smoothing.
#ifndef KINEGRAPH_SOLVERS_FILTERS_SAVITZKY_GOLAY_H_
#define KINEGRAPH_SOLVERS_FILTERS_SAVITZKY_GOLAY_H_

#include <cstdint>

#include "solvers/filters/joint_segment.h"
#include "solvers/filters/options.h"

namespace kinegraph {

// The odd number of frames nearest to the window, at least order + 1.
int SavitzkyGolayLength(const SavitzkyGolayOptions& options, double rate_hz);

// Each value becomes that of the polynomial of `order` >= 0 fitted by least
// squares to the `length` (odd, > order) values around it (Savitzky and Golay
// 1964); the first and last (length - 1) / 2 take theirs from the first and
// last full window, as scipy.signal.savgol_filter(mode='interp'). Fewer values
// than `length`: one polynomial through all of them, of at most one order less
// than there are.
Samples SavitzkyGolay(int length, int order, const Samples& values);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FILTERS_SAVITZKY_GOLAY_H_
