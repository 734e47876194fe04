// One factor on all sigmas of a person, from the residuals.
#ifndef KINEGRAPH_SOLVERS_GRAPH_NOISE_SCALE_H_
#define KINEGRAPH_SOLVERS_GRAPH_NOISE_SCALE_H_

#include <vector>

#include "solvers/graph/problem.h"

namespace kinegraph {

// Squared whitened residuals |r|^2 of a chain at its states, each divided by
// the share 1 - trace(J C J') / 2 that the estimate's own error leaves of it
// (C: covariances of the states). Appended to `squares`.
void CollectSquares(const JointChain& chain,
                    const std::vector<Matrix6d>& covariances,
                    std::vector<double>* squares);

// The scale at which `squares` are those of standard normal 2-vectors, outliers
// aside: starts at the median and then takes the mean of those within three
// sigmas. Drawn towards 1 while there are few, bounded to 1/4 .. 4.
double EstimateNoiseScale(std::vector<double> squares);

// Multiplies all sigmas.
void ScaleSigmas(double scale, PersonProblem* problem);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_GRAPH_NOISE_SCALE_H_
