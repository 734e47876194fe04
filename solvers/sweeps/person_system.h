// A person's joints coupled by bones, linearised.
#ifndef KINEGRAPH_SOLVERS_SWEEPS_PERSON_SYSTEM_H_
#define KINEGRAPH_SOLVERS_SWEEPS_PERSON_SYSTEM_H_

#include <Eigen/Core>
#include <vector>

#include "solvers/graph/problem.h"
#include "solvers/sweeps/block_tridiagonal.h"
#include "solvers/sweeps/linear_chain.h"

namespace kinegraph {

// What a factor on the positions of two joints in one frame adds between them:
// the information by_a by_b'.
struct PointCoupling {
  int a = 0;
  int b = 0;
  size_t frame = 0;
  Eigen::Vector3d by_a;
  Eigen::Vector3d by_b;
};

// Gauss-Newton system of a person: a chain for each joint (the diagonal parts
// of coupling factors included) and what couples the joints within a frame.
struct PersonSystem {
  std::vector<LinearChain> chains;
  std::vector<PointCoupling> couplings;
  // Information of the person's prior, the same at any states; of it the
  // joints' own blocks stand in the chains. Empty without one.
  Eigen::MatrixXd prior_coupling;
  double cost = 0.0;
};

// `system` holds the prior's coupling already (PriorCoupling). False where a
// measurement that is not gated has no image.
bool Linearise(const PersonProblem& problem, const PersonStates& states,
               const SolveStage& stage, PersonSystem* system);

// A'A without the joints' own blocks; empty without a prior.
Eigen::MatrixXd PriorCoupling(const Eigen::MatrixXd& A);

// H x, with `damping` times the diagonal added.
void Multiply(const PersonSystem& system, double damping, const PersonStates& x,
              PersonStates* product);

// Covariances of every joint's state in every frame by exact block-tridiagonal
// selected inversion, frames as blocks. Factors are kept for a stretch of
// frames only and computed again on the way back, so memory stays small.
// covariances[joint][frame]; only frames before `frame_end` are kept. False
// where the information is not positive definite.
bool PersonCovariances(const PersonProblem& problem, double correction,
                       size_t frame_end,
                       std::vector<std::vector<Matrix6d>>* covariances);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SWEEPS_PERSON_SYSTEM_H_
