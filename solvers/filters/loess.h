// Locally weighted regression.
#ifndef KINEGRAPH_SOLVERS_FILTERS_LOESS_H_
#define KINEGRAPH_SOLVERS_FILTERS_LOESS_H_

#include <vector>

#include "solvers/filters/joint_segment.h"

namespace kinegraph {

// LOESS (Cleveland 1979) at the times `at`: the value of a polynomial of
// `degree` fitted to the `neighbours` nearest values, each weighted by (1 -
// (distance / greatest distance)^3)^3. `iterations` times, every value is
// reweighted by (1 - (r / (6 s))^2)^2, zero for r > 6 s, where r is the length
// of its residual over all columns and s the median of r: a point is an outlier
// in all axes or in none. Reweighting ends when s is zero; where all neighbours
// are outliers, they keep their distance weights. `times` and `at` ascend and
// may be non-uniform. `neighbours` >= degree + 2; if there are fewer values,
// all are used.
Samples Loess(int neighbours, int degree, int iterations,
              const std::vector<double>& times, const Samples& values,
              const std::vector<double>& at);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FILTERS_LOESS_H_
