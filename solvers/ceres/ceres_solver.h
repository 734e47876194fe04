// A person's problem through Ceres.
#ifndef KINEGRAPH_SOLVERS_CERES_CERES_SOLVER_H_
#define KINEGRAPH_SOLVERS_CERES_CERES_SOLVER_H_

#include <functional>
#include <vector>

#include "solvers/graph/problem.h"

namespace kinegraph {

// How far a step of Gauss-Newton would move any position [m], from the cost's
// gradient by all states, joint by joint and frame by frame.
using StepLength = std::function<double(const std::vector<double>& gradient)>;

// Runs the stages from the problem's states, which receive the minimum;
// measurements get their weights there. One ceres::Problem a stage holds all
// of the person: every factor of factor_list.h, the person's prior and the
// user's factors. Sparse normal equations, trust region, one thread;
// converged when no joint moves by more than the schedule's tolerance in an
// undamped step. Ceres' own summary is logged at VLOG level 2.
// With `step_length` the problem's first evaluation decides whether a step is
// needed at all; where none is, states and weights stay as they are.
SolveReport SolveWithCeres(const SolveSchedule& schedule,
                           PersonProblem* problem,
                           const StepLength& step_length = nullptr);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_CERES_CERES_SOLVER_H_
