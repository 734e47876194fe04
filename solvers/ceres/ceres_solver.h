// A person's problem through Ceres.
#ifndef KINEGRAPH_SOLVERS_CERES_CERES_SOLVER_H_
#define KINEGRAPH_SOLVERS_CERES_CERES_SOLVER_H_

#include "solvers/graph/problem.h"

namespace kinegraph {

// Runs the stages from the problem's states, which receive the minimum;
// measurements get their weights there. One ceres::Problem a stage holds all
// of the person: every factor of factor_list.h, the person's prior and the
// user's factors. Sparse normal equations, trust region, one thread;
// converged when no joint moves by more than the schedule's tolerance in an
// undamped step. Ceres' own summary is logged at VLOG level 2.
SolveReport SolveWithCeres(const SolveSchedule& schedule,
                           PersonProblem* problem);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_CERES_CERES_SOLVER_H_
