// The One-Euro filter.
#ifndef KINEGRAPH_SOLVERS_FILTERS_ONE_EURO_H_
#define KINEGRAPH_SOLVERS_FILTERS_ONE_EURO_H_

#include <vector>

#include "solvers/filters/joint_segment.h"
#include "solvers/filters/options.h"

namespace kinegraph {

// Exponential smoothing whose cut-off grows with the smoothed speed (Casiez,
// Roussel and Vogel, CHI 2012, algorithm 1), column by column, by the real time
// between two values. The first value passes. The speed is that from the last
// filtered value to the new raw one, as in the paper; the authors' programs
// took the last raw value until August 2023.
Samples OneEuro(const OneEuroOptions& options,
                const std::vector<double>& times_s, const Samples& values);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FILTERS_ONE_EURO_H_
