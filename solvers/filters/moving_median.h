// Moving median and the Hampel identifier.
#ifndef KINEGRAPH_SOLVERS_FILTERS_MOVING_MEDIAN_H_
#define KINEGRAPH_SOLVERS_FILTERS_MOVING_MEDIAN_H_

#include <vector>

#include "core/base/options.h"
#include "solvers/filters/joint_segment.h"

namespace kinegraph {

// Which values a place sees. Time need not be uniform; at the ends there are
// fewer.
enum class WindowSide {
  kCentred,   // at most half the window away
  kTrailing,  // itself and those before, less than the window away
};

struct HampelMedianOptions {
  double hampel_window_s = 0.28;  // 7 frames at 25 Hz
  double hampel_threshold = 3.0;  // standard deviations, by the MAD
  double median_window_s = 0.2;   // 5 frames at 25 Hz
  WindowSide side = WindowSide::kCentred;

  // Table [filters.hampel_median].
  void Describe(OptionVisitor& visitor);
};

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
