// A person's problem through Ceres.
#ifndef KINEGRAPH_SOLVERS_CERES_CERES_SOLVER_H_
#define KINEGRAPH_SOLVERS_CERES_CERES_SOLVER_H_

#include <memory>

#include "solvers/graph/problem.h"

namespace kinegraph {

// Minimises all factors of a person at once: those of factor_list.h, the
// person's prior and the user's factors. Trust region, sparse normal equations,
// one thread.
//
// One ceres::Problem lives as long as the solver. A window's pattern hardly
// changes: its blocks are those of frame 0, 1, ... of the window, and what
// moves on when a frame comes and another leaves are the numbers in them.
// Blocks are added at the end when there are more frames, and removed there
// when there are fewer. States and factors lie here and belong to the solver,
// not to Ceres. Which blocks there are, and in which order, depends on the
// problem at hand alone: the result does not depend on what was solved before.
class CeresSolver {
 public:
  CeresSolver();
  ~CeresSolver();
  CeresSolver(CeresSolver&&) noexcept;
  CeresSolver& operator=(CeresSolver&&) noexcept;

  // Runs the stages from the problem's states, with the measurements gated as
  // they are. States receive the minimum, measurements their weights there.
  // Ceres ends each stage: at its start where the gradient is as good as zero
  // (GradientTolerance in the source), or when a step that nothing damps moves
  // no joint by more than the schedule's tolerance. Where a stage finds nothing
  // finite its start stays, and later ones are not tried. Ceres' own summary is
  // logged at VLOG level 2.
  SolveReport Solve(const SolveSchedule& schedule, PersonProblem* problem);

 private:
  class Graph;
  std::unique_ptr<Graph> graph_;
};

// The same with a solver of its own.
SolveReport SolveWithCeres(const SolveSchedule& schedule,
                           PersonProblem* problem);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_CERES_CERES_SOLVER_H_
