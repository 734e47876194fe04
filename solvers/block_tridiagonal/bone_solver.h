// Damped Gauss-Newton over all joints of a person at once.
#ifndef KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_BONE_SOLVER_H_
#define KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_BONE_SOLVER_H_

#include <Eigen/Core>
#include <vector>

#include "solvers/block_tridiagonal/chain_solver.h"
#include "solvers/graph/problem.h"

namespace kinegraph {

// Where Gauss-Newton takes a curvature for larger than it is (a short bone that
// is pressed together, views that hardly count), its steps creep along a
// valley, each by a share q of the one before. Their sum is the geometric
// series' (Aitken): returns how many times the last step is still to come, q /
// (1 - q), from the squared norms of the last two and their product; 0 where
// they do not look like that.
double StepsToCome(double previous_squared, double squared, double product);

// As ChainSolver for problems with bones: each linear system is solved by
// conjugate gradients, preconditioned with the joints' chains, which bones
// couple only weakly. Joints lie in lanes. Keeps its work space between calls;
// not for use by two threads at a time.
class BoneSolver {
 public:
  // From the joints' states, with the measurements gated as they are.
  SolveReport Solve(const SolveSchedule& schedule, PersonProblem* problem);

  // A step of Gauss-Newton from the problem's states.
  struct StepSize {
    double length_m;  // the farthest that a position moves
    // sqrt(g' H^-1 g): no state moves by more of its standard deviations.
    double decrement;
  };
  // Down the gradient that the factors (factor_list.h) have one by one, in
  // doubles: a fault of the lanes does not hide there. Infinite where there is
  // none.
  StepSize SizeOfStep(const PersonProblem& problem, const SolveStage& stage);
  // Whether that step is shorter than the tolerance, or than anything that the
  // measurements could tell: where nobody sees a joint, long steps mean little.
  bool IsAtMinimum(const PersonProblem& problem, const SolveStage& stage,
                   double step_tolerance_m);

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
  // False where a factor has no value.
  bool LoadGradient(const PersonProblem& problem, const SolveStage& stage);
  // Of H step = -gradient; false where it is not positive definite. `accuracy`
  // as that of LaneKernels::solve_coupled.
  bool FindStep(double damping, double accuracy);
  // candidate = states + scale step; returns how far that moves a position [m].
  double MoveCandidate(double scale);
  void KeepCandidate();
  bool RunStage(const PersonProblem& problem, const SolveStage& stage,
                double step_tolerance_m, SolveReport* report);
  // Goes on along a step that creeps, as far as the cost falls.
  void LeapAhead(const PersonProblem& problem, const SolveStage& stage);
  double Dot(const LaneBuffer& a, const LaneBuffer& b) const;
  void Unload(const SolveSchedule& schedule, SolveReport* report,
              PersonProblem* problem);

  LaneProblem lanes_;
  System system_;
  System trial_;
  // Information of the person's prior: the joints' own blocks as LaneBlock, and
  // what is between joints (LaneCouplings::first). Empty without one.
  Eigen::MatrixXd prior_own_;    // [lanes x 21]
  Eigen::MatrixXd prior_cross_;  // [6 lanes x 6 joints]
  LaneBuffer candidate_, step_, previous_step_, workspace_;
  bool has_previous_ = false;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_BONE_SOLVER_H_
