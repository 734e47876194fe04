// A person's joints coupled by bones, linearised.
#ifndef KINEGRAPH_SOLVERS_GRAPH_PERSON_SYSTEM_H_
#define KINEGRAPH_SOLVERS_GRAPH_PERSON_SYSTEM_H_

#include <Eigen/Core>
#include <vector>

#include "solvers/graph/block_tridiagonal.h"
#include "solvers/graph/linear_chain.h"
#include "solvers/graph/problem.h"

namespace kinegraph {

// States of all joints: [joint][frame].
using PersonStates = std::vector<std::vector<State>>;

// Gauss-Newton system of a person: a chain for each joint (the bones' diagonal
// parts included) and what couples the joints within a frame.
struct PersonSystem {
  std::vector<LinearChain> chains;
  // Whitened direction n / sigma of every bone, [bone][frame]: the information
  // between its ends is -d d'.
  std::vector<std::vector<Eigen::Vector3d>> directions;
  // Information of the person's prior between different joints' first states;
  // empty without one.
  Eigen::MatrixXd prior_coupling;
  double cost = 0.0;
};

// False where a measurement that is not gated has no image.
bool Linearise(const PersonProblem& problem, const PersonStates& states,
               const SolveStage& stage, PersonSystem* system);

// H x, with `damping` times the diagonal added.
void Multiply(const PersonProblem& problem, const PersonSystem& system,
              double damping, const PersonStates& x, PersonStates* product);

// Covariances of every joint's state in every frame by exact block-tridiagonal
// selected inversion, frames as blocks. Factors are kept for a stretch of
// frames only and computed again on the way back, so memory stays small.
// covariances[joint][frame]; only frames before `frame_end` are kept. False
// where the information is not positive definite.
bool PersonCovariances(const PersonProblem& problem, double correction,
                       size_t frame_end,
                       std::vector<std::vector<Matrix6d>>* covariances);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_GRAPH_PERSON_SYSTEM_H_
