// Locally weighted regression.
#ifndef KINEGRAPH_SOLVERS_FILTERS_LOESS_H_
#define KINEGRAPH_SOLVERS_FILTERS_LOESS_H_

#include <vector>

#include "solvers/filters/joint_segment.h"

namespace kinegraph {

// LOESS (Cleveland 1979) at the times `at`: the value of a polynomial of
// `degree` fitted to the `neighbours` nearest values, each weighted by
// (1 - (distance / that of the farthest)^3)^3. `iterations` times, every value
// is weighted anew by (1 - (r / 6 m)^2)^2, r the length of its residual over
// all columns, m the median of them, zero beyond 6 m: an outlier is one of the
// point, whatever the axes. `times` ascend and need not be uniform.
// `neighbours` >= degree + 2; of fewer values all count.
Samples Loess(int neighbours, int degree, int iterations,
              const std::vector<double>& times, const Samples& values,
              const std::vector<double>& at);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FILTERS_LOESS_H_
