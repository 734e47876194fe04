// Damped Gauss-Newton over the chains of joints by block-tridiagonal sweeps,
// joints side by side in lanes.
#ifndef KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_CHAIN_SOLVER_H_
#define KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_CHAIN_SOLVER_H_

#include <Eigen/Core>
#include <vector>

#include "core/base/pack.h"
#include "solvers/block_tridiagonal/lane_problem.h"
#include "solvers/graph/problem.h"

namespace kinegraph {

// Finds the minima that Ceres finds with the same factors (a test compares
// them), at the cost of a few sweeps. Each chain is solved as if it were alone,
// and has the same bits in any company and on any instruction set. Keeps its
// work space between calls; not for use by two threads at a time.
class ChainSolver {
 public:
  // Gates the measurements at the chains' states and runs the stages one after
  // the other from there. States receive the minimum, measurements whether they
  // are gated and their weights there. All chains have the frames of `times`.
  std::vector<SolveReport> Solve(const std::vector<TimeNs>& times,
                                 const SolveSchedule& schedule,
                                 const std::vector<JointChain*>& chains);

  // Covariances of the states of frames before `frame_end` at the chains'
  // states and weights, [chain][frame], position [m^2] first; `correction` as
  // InformationCorrection gives it. Empty for a chain whose information is not
  // positive definite.
  std::vector<std::vector<Matrix6d>> Covariances(
      const std::vector<TimeNs>& times,
      const std::vector<const JointChain*>& chains, double correction,
      size_t frame_end);

 private:
  // Chains that share a call of the kernel.
  static constexpr size_t kGroup = kLaneMultiple;

  void Load(const std::vector<TimeNs>& times,
            const std::vector<const JointChain*>& chains);
  void SolveGroup(const std::vector<TimeNs>& times,
                  const SolveSchedule& schedule,
                  const std::vector<JointChain*>& chains,
                  std::vector<SolveReport>* reports);
  void CovariancesOfGroup(const std::vector<TimeNs>& times,
                          const std::vector<const JointChain*>& chains,
                          double correction, size_t frame_end,
                          std::vector<std::vector<Matrix6d>>* covariances);
  SolveReport Unload(size_t lane, const SolveSchedule& schedule,
                     JointChain* chain);

  LaneProblem lanes_;
  LaneBuffer steps_, finite_, converged_, iterations_, covariances_, known_,
      workspace_;
  StateChain step_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_CHAIN_SOLVER_H_
