// Damped Gauss-Newton over all joints of a person at once.
#ifndef KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_BONE_SOLVER_H_
#define KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_BONE_SOLVER_H_

#include <Eigen/Core>
#include <vector>

#include "solvers/block_tridiagonal/chain_solver.h"
#include "solvers/graph/problem.h"

namespace kinegraph {

// As ChainSolver for problems with bones: each linear system is solved by
// conjugate gradients, preconditioned with the joints' chains, which bones
// couple only weakly. Joints lie in lanes. Keeps its work space between calls;
// not for use by two threads at a time.
class BoneSolver {
 public:
  // From the joints' states, with the measurements gated as they are, or anew
  // where one that counts has no image. Where nothing finite is found the
  // states stay as they are.
  SolveReport Solve(const SolveSchedule& schedule, PersonProblem* problem);

 private:
  // All joints' chains (the diagonal parts of what couples them included) and
  // the couplings, at some states.
  struct System {
    LaneBuffer diagonal;
    LaneBuffer gradient;
    LaneBuffer costs;  // of each lane
    LaneBuffer valid;
    std::vector<LaneCoupling> couplings;
    double cost = 0.0;

    LaneSystemRows rows() {
      return {diagonal.data(), gradient.data(), costs.data(), valid.data()};
    }
  };

  void Load(const PersonProblem& problem);
  void LoadPrior(const PersonPrior& prior);
  ChainLanes At(LaneBuffer* states) const;
  // False where a measurement that counts has no image.
  bool Linearise(const PersonProblem& problem, const SolveStage& stage,
                 LaneBuffer* states, System* system);
  void AddCouplings(const PersonProblem& problem, const LaneBuffer& states,
                    System* system) const;
  void AddPrior(const PersonPrior& prior, const LaneBuffer& states,
                System* system) const;
  // Of H step = -gradient; false where it is not positive definite. `accuracy`
  // as that of LaneKernels::solve_coupled.
  bool FindStep(double damping, double accuracy);
  // candidate = states + step; returns how far that moves a position [m].
  double MoveCandidate();
  void KeepCandidate();
  bool RunStage(const PersonProblem& problem, const SolveStage& stage,
                double step_tolerance_m, SolveReport* report);
  bool AllFinite(const LaneBuffer& states) const;
  void Unload(const SolveSchedule& schedule, SolveReport* report,
              PersonProblem* problem);

  LaneProblem lanes_;
  System system_;
  System trial_;
  // Information of the person's prior: the joints' own blocks as LaneBlock, and
  // what is between joints (LaneCouplings::first). Empty without one.
  Eigen::MatrixXd prior_own_;    // [lanes x 21]
  Eigen::MatrixXd prior_cross_;  // [6 lanes x 6 joints]
  LaneBuffer candidate_, step_, workspace_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_BONE_SOLVER_H_
