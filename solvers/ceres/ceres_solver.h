// The same problems through Ceres: the reference of every other solver.
#ifndef KINEGRAPH_SOLVERS_CERES_CERES_SOLVER_H_
#define KINEGRAPH_SOLVERS_CERES_CERES_SOLVER_H_

#include "solvers/graph/problem.h"

namespace kinegraph {

// As ChainSolver::Solve, with Ceres' trust region and sparse Cholesky
// factorisation (one thread). Joints that no bone or prior couples are solved
// one by one. With bones all joints are one problem.
SolveReport SolveWithCeres(const SolveSchedule& schedule,
                           PersonProblem* problem);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_CERES_CERES_SOLVER_H_
