// The convexity schedule of a robust solve.
#ifndef KINEGRAPH_SOLVERS_GRAPH_SCHEDULE_H_
#define KINEGRAPH_SOLVERS_GRAPH_SCHEDULE_H_

#include "solvers/graph/options.h"
#include "solvers/graph/problem.h"

namespace kinegraph {

// Convex losses need one stage. The others start with Huber, whose only
// minimum does not depend on the start, and then narrow to their own scale
// (graduated non-convexity: Blake and Zisserman 1987; Yang et al., RA-L 2020).
// A redescending loss that starts from an old estimate instead can lock good
// views out for ever, so every window runs the whole schedule again.
SolveSchedule MakeSchedule(const GraphOptions& options);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_GRAPH_SCHEDULE_H_
