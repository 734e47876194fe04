// Moving median and the Hampel identifier.
#ifndef KINEGRAPH_SOLVERS_FILTERS_MOVING_MEDIAN_H_
#define KINEGRAPH_SOLVERS_FILTERS_MOVING_MEDIAN_H_

#include <vector>

#include "solvers/filters/joint_segment.h"
#include "solvers/filters/options.h"

namespace kinegraph {

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

#endif  // KINEGRAPH_SOLVERS_FILTERS_MOVING_MEDIAN_H_
