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
// second states, by Schur complement. With x1 the states of the first frame, x2
// those of the second, and the factors that touch x1 linearised at the
// estimate, the cost is, but for a constant,
//   1/2 [d1 d2] [L11 L21'] [d1] + [g1' g2'] [d1]
//               [L21 L22 ] [d2]             [d2]
// in the steps d1, d2. Whatever d2 is, d1 = -L11^-1 (g1 + L21' d2) is best; put
// in, it leaves a prior on d2 alone,
//   information L22 - L21 L11^-1 L21',   gradient g2 - L21 L11^-1 g1,
// whose minimum and inverse are those of the whole problem's second frame: what
// later factors add concerns d2 only. L11 = C C' is factored once; the columns
// of C^-1 L21' are what the product subtracts. Without bones, L11 falls into a
// block a joint, which EliminateDense uses.
// nullopt where the information is not positive definite, which takes a factor
// of the user's own that says so.
std::optional<PersonPrior> MarginaliseFirstFrame(const PersonProblem& problem,
                                                 double correction);

// Replaces the first frame of every joint by such a prior; with bones, or a
// person's prior from earlier ones, also the person's.
void DropFirstFrame(double correction, PersonProblem* problem);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_GRAPH_MARGINALISE_FRAME_H_
