// The factors of one joint's chain, linearised at given states.
#ifndef KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_LINEAR_CHAIN_H_
#define KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_LINEAR_CHAIN_H_

#include <Eigen/Core>
#include <vector>

#include "solvers/graph/problem.h"

namespace kinegraph {

// Gauss-Newton system of a chain: diagonal blocks, blocks right of them,
// gradient; and what it costs there.
struct LinearChain {
  std::vector<Matrix6d> diagonal;
  std::vector<Matrix6d> upper;
  std::vector<State> gradient;
  std::vector<double> weights;  // rho' of every measurement
  double cost = 0.0;

  // Sizes everything and fills it with zeros.
  void Reset(size_t frames, size_t measurements);
};

// Whether a chain's own prior counts (JointChain::prior). It does not where the
// person's prior stands in its place (PersonProblem::prior).
enum class OwnPrior { kCounts, kReplaced };

// The chain's system at `states`. False where a measurement that is not gated
// has no image there.
bool Linearise(const std::vector<TimeNs>& times, const JointChain& chain,
               const StateChain& states, const SolveStage& stage,
               OwnPrior own_prior, LinearChain* linear);

// Blocks of the information at the chain's states and stored weights, each
// observation's times `correction` (InformationCorrection of its loss).
// Gradient and cost are not filled.
void LineariseInformation(const std::vector<TimeNs>& times,
                          const JointChain& chain, double correction,
                          OwnPrior own_prior, LinearChain* linear);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_LINEAR_CHAIN_H_
