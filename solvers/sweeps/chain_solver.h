// Damped Gauss-Newton over one joint's chain by block-tridiagonal sweeps.
#ifndef KINEGRAPH_SOLVERS_SWEEPS_CHAIN_SOLVER_H_
#define KINEGRAPH_SOLVERS_SWEEPS_CHAIN_SOLVER_H_

#include <Eigen/Core>
#include <vector>

#include "solvers/graph/problem.h"
#include "solvers/sweeps/block_tridiagonal.h"
#include "solvers/sweeps/linear_chain.h"

namespace kinegraph {

// Finds the minimum that Ceres finds with the same factors (a test compares
// them), at the cost of a few sweeps. Keeps its work space between calls; not
// for use by two threads at a time.
class ChainSolver {
 public:
  // Runs the stages one after the other from chain->states, which receive the
  // minimum; weights of the measurements are those there.
  SolveReport Solve(const std::vector<TimeNs>& times,
                    const SolveSchedule& schedule, JointChain* chain);

  // Covariances of all states at the chain's states and weights, position
  // [m^2] first; `correction` as InformationCorrection gives it. False where
  // the information is not positive definite.
  bool Covariances(const std::vector<TimeNs>& times, const JointChain& chain,
                   double correction, std::vector<Matrix6d>* covariances);

 private:
  bool RunStage(const std::vector<TimeNs>& times, const SolveStage& stage,
                double step_tolerance_m, const JointChain& chain,
                SolveReport* report);

  LinearChain linear_;
  LinearChain trial_;
  BlockTridiagonal<kStateSize> factor_;
  StateChain states_;
  StateChain step_;
  StateChain candidate_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SWEEPS_CHAIN_SOLVER_H_
