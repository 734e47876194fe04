// Gauss-Newton that creeps along a valley.
#ifndef KINEGRAPH_SOLVERS_GRAPH_CREEP_H_
#define KINEGRAPH_SOLVERS_GRAPH_CREEP_H_

#include "solvers/graph/problem.h"

namespace kinegraph {

// Where Gauss-Newton takes a curvature for larger than it is (a short bone that
// is pressed together, views that hardly count), its steps go one way, each by
// a share q of the one before. Their sum is the geometric series' (Aitken):
// returns how many times `step` is still to come, q / (1 - q), or 0 where the
// last two steps do not look like that.
double StepsToCome(const PersonStates& previous_step, const PersonStates& step);

// The same from the steps' squared norms and their product.
double StepsToCome(double previous_squared, double squared, double product);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_GRAPH_CREEP_H_
