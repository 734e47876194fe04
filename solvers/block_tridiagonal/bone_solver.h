// Damped Gauss-Newton over all joints of a person at once.
#ifndef KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_BONE_SOLVER_H_
#define KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_BONE_SOLVER_H_

#include <Eigen/Core>
#include <vector>

#include "solvers/block_tridiagonal/chain_solver.h"
#include "solvers/graph/problem.h"

namespace kinegraph {

// ChainSolver for problems with bones or a PersonProblem::prior; ignores the
// user's factors. Each linear system is solved by conjugate gradients,
// preconditioned with the joints' chains, which bones couple only weakly. One
// joint per SIMD lane. All stages have the last stage's step tolerance. Reuses
// its work space between calls; not thread-safe.
class BoneSolver {
 public:
  // Starts at the joints' states. Keeps the gating of measurements, unless the
  // joint of an active measurement cannot be projected into its view (it lies
  // behind the camera, for example) or the cost is not finite: then all are
  // gated anew.
  // Without a finite result the states are unchanged.
  SolveReport Solve(const SolveSchedule& schedule, PersonProblem* problem);

 private:
  // All joints' chains (with the diagonal parts of the coupling factors) and
  // the couplings, linearised at given states.
  struct System {
    LaneBuffer diagonal;
    LaneBuffer gradient;
    LaneBuffer costs;  // per lane
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
  // False if the joint of an active measurement cannot be projected or the cost
  // is not finite.
  bool Linearise(const PersonProblem& problem, const SolveStage& stage,
                 LaneBuffer* states, System* system);
  void AddCouplings(const PersonProblem& problem, const LaneBuffer& states,
                    System* system) const;
  void AddPrior(const PersonPrior& prior, const LaneBuffer& states,
                System* system) const;
  // Solves H step = -gradient by LaneKernels::solve_coupled, which describes
  // `accuracy`; false if that fails.
  bool FindStep(double damping, double accuracy);
  // candidate = states + scale step; returns the largest movement of a
  // position along an axis [m].
  double MoveCandidate(double scale);
  void KeepCandidate();
  double Dot(const LaneBuffer& a, const LaneBuffer& b) const;
  // After an accepted step: extrapolates this step and the previous one to the
  // limit of their geometric series, if the cost is lower there.
  void LeapAhead(const PersonProblem& problem, const SolveStage& stage);
  bool RunStage(const PersonProblem& problem, const SolveStage& stage,
                double step_tolerance_m, SolveReport* report);
  bool AllFinite();  // all states
  void Unload(const SolveSchedule& schedule, SolveReport* report,
              PersonProblem* problem);

  LaneProblem lanes_;
  System system_;
  System trial_;
  // Information of the person's prior: the joints' own blocks as LaneBlock, and
  // the blocks between joints (LaneCouplings::first). Empty without a prior.
  Eigen::MatrixXd prior_own_;    // [lanes x 21]
  Eigen::MatrixXd prior_cross_;  // [6 lanes x 6 joints]
  LaneBuffer candidate_, step_, workspace_;
  LaneBuffer before_;            // the previous step
  double before_squared_ = 0.0;  // squared norm of before_; 0: do not use it
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_BONE_SOLVER_H_
