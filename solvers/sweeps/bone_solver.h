// Damped Gauss-Newton over all joints of a person at once.
#ifndef KINEGRAPH_SOLVERS_SWEEPS_BONE_SOLVER_H_
#define KINEGRAPH_SOLVERS_SWEEPS_BONE_SOLVER_H_

#include <vector>

#include "solvers/graph/problem.h"
#include "solvers/sweeps/block_tridiagonal.h"
#include "solvers/sweeps/person_system.h"

namespace kinegraph {

// As ChainSolver for problems with bones: each linear system is solved by
// conjugate gradients, preconditioned with the joints' chains, which bones
// couple only weakly. Keeps its work space between calls.
class BoneSolver {
 public:
  SolveReport Solve(const SolveSchedule& schedule, PersonProblem* problem);

 private:
  bool RunStage(const SolveStage& stage, double step_tolerance_m,
                PersonProblem* problem, SolveReport* report);
  // Goes on along a step that creeps, if the cost falls (creep.h).
  void LeapAhead(const SolveStage& stage, PersonProblem* problem);
  bool Precondition(double damping);
  // Solves H step = -gradient.
  void SolveLinear(double damping);

  PersonSystem system_;
  PersonSystem trial_;
  std::vector<BlockTridiagonal<kStateSize>> factors_;
  PersonStates states_;
  PersonStates candidate_;
  PersonStates step_;
  PersonStates previous_step_;  // empty: none to compare with
  PersonStates residual_;
  PersonStates conditioned_;
  PersonStates direction_;
  PersonStates product_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SWEEPS_BONE_SOLVER_H_
