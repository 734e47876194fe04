// Which estimator serves association and which one is written.
#ifndef KINEGRAPH_SOLVERS_FACTORY_H_
#define KINEGRAPH_SOLVERS_FACTORY_H_

#include "core/base/options.h"
#include "core/tracking/estimator.h"
#include "solvers/filters/causal_gaussian.h"

namespace kinegraph {

enum class Mode {
  kPaper,  // the paper's causal Gaussian in both roles
  kGraph,  // the factor graph
};

struct EstimatorOptions {
  Mode mode = Mode::kPaper;
  CausalGaussianOptions gaussian;

  // Key "mode", table [gaussian].
  void Describe(OptionVisitor& visitor);
};

// Factories of the two roles. An empty `output` means that the feedback
// estimator's own poses are written.
struct EstimatorPair {
  EstimatorFactory feedback;
  EstimatorFactory output;
};

// Throws OptionError for a pair that does not exist.
EstimatorPair MakeEstimators(const EstimatorOptions& options);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FACTORY_H_
