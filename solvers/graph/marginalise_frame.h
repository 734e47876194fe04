// Drops the first frame of a person's problem.
#ifndef KINEGRAPH_SOLVERS_GRAPH_MARGINALISE_FRAME_H_
#define KINEGRAPH_SOLVERS_GRAPH_MARGINALISE_FRAME_H_

#include <optional>

#include "solvers/graph/problem.h"

namespace kinegraph {

// The prior on a chain's second state that its first state's factors leave:
// prior, measurements at their weights, motion. `correction` is that of the
// loss (InformationCorrection); it enters A_stated alone. The chain needs two
// states.
StatePrior MarginaliseFirstState(const std::vector<TimeNs>& times,
                                 const JointChain& chain, double correction);

// The same for all joints together, where bones couple them: a prior on their
// second states, by Schur complement. nullopt where the information is not
// positive definite, which takes a factor of the user's own that says so.
std::optional<PersonPrior> MarginaliseFirstFrame(const PersonProblem& problem,
                                                 double correction);

// Replaces the first frame of every joint by such a prior; with bones, or a
// person's prior from earlier ones, also the person's.
void DropFirstFrame(double correction, PersonProblem* problem);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_GRAPH_MARGINALISE_FRAME_H_
