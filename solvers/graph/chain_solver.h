// Damped Gauss-Newton over one joint's chain by block-tridiagonal sweeps.
#ifndef KINEGRAPH_SOLVERS_GRAPH_CHAIN_SOLVER_H_
#define KINEGRAPH_SOLVERS_GRAPH_CHAIN_SOLVER_H_

#include <Eigen/Core>
#include <vector>

#include "solvers/graph/block_tridiagonal.h"
#include "solvers/graph/linear_chain.h"
#include "solvers/graph/problem.h"

namespace kinegraph {

// N is the size of a state, as in LinearChainOf. Finds the minimum that Ceres
// finds with the factors of solvers/factors (a test compares them), at the cost
// of a few sweeps. Keeps its work space between calls; not for use by two
// threads at a time.
template <int N>
class ChainSolverOf {
 public:
  // Runs the stages one after the other from chain->states (and accelerations
  // with N = 9), which receive the minimum; weights of the measurements are
  // those there.
  SolveReport Solve(const std::vector<TimeNs>& times,
                    const SolveSchedule& schedule, JointChain* chain);

  // Covariances of position and velocity of all states at the chain's states
  // and weights, position [m^2] first; `correction` as InformationCorrection
  // gives it. False where the information is not positive definite.
  bool Covariances(const std::vector<TimeNs>& times, const JointChain& chain,
                   double correction, std::vector<Matrix6d>* covariances);

 private:
  bool RunStage(const std::vector<TimeNs>& times, const SolveStage& stage,
                double step_tolerance_m, const JointChain& chain,
                SolveReport* report);

  using Vector = Eigen::Matrix<double, N, 1>;

  LinearChainOf<N> linear_;
  LinearChainOf<N> trial_;
  BlockTridiagonal<N> factor_;
  std::vector<Vector> states_;
  std::vector<Vector> step_;
  std::vector<Vector> candidate_;
  std::vector<State> last_step_;
};
// White noise on acceleration, and on jerk.
using ChainSolver = ChainSolverOf<kStateSize>;
using JerkChainSolver = ChainSolverOf<kStateSize + 3>;

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_GRAPH_CHAIN_SOLVER_H_
