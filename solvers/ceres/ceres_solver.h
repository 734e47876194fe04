// Solves a person's problem with Ceres.
#ifndef KINEGRAPH_SOLVERS_CERES_CERES_SOLVER_H_
#define KINEGRAPH_SOLVERS_CERES_CERES_SOLVER_H_

#include <memory>

#include "solvers/graph/problem.h"

namespace kinegraph {

// Minimises the cost of all factors of a person at once: the factors of
// factor_list.h, the person's prior and the user's factors. Uses a trust
// region, sparse normal equations and one thread.
//
// One ceres::Problem persists between solves, because a window's structure
// hardly changes: its blocks belong to frames 0, 1, ... of the window, and only
// their values are replaced as the window advances. Blocks are added or removed
// at the end when the number of frames changes; the user's factors are added
// for each solve and removed after it. The solver, not Ceres, owns states and
// factors. The blocks and their order depend on the current problem only, so
// the result does not depend on earlier solves.
class CeresSolver {
 public:
  CeresSolver();
  ~CeresSolver();
  CeresSolver(CeresSolver&&) noexcept;
  CeresSolver& operator=(CeresSolver&&) noexcept;

  // Runs the stages from the problem's states. The measurements stay gated as
  // they are, unless the cost is undefined at the start of a stage: then they
  // are gated anew. States receive the minimum, measurements their weights
  // there. Ceres ends a stage where the gradient is negligible
  // (GradientTolerance in the source), when a step hardly lowers the cost or,
  // undamped, moves no joint by more than the schedule's tolerance, or after
  // the stage's maximum number of iterations. If a stage has no finite result,
  // its start and the measurements' weights are kept and later stages are
  // skipped. Ceres' own summary is logged at VLOG level 2.
  SolveReport Solve(const SolveSchedule& schedule, PersonProblem* problem);

 private:
  class Graph;
  std::unique_ptr<Graph> graph_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_CERES_CERES_SOLVER_H_
