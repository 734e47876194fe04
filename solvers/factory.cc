#include "solvers/factory.h"

#include "core/base/error.h"

namespace kinegraph {

void EstimatorOptions::Describe(OptionVisitor& visitor) {
  visitor.Choice("mode", &mode, {"paper", "graph"},
                 "the pair of estimators: the paper's, or the factor graph");
  visitor.Enter("gaussian");
  gaussian.Describe(visitor);
  visitor.Leave();
}

EstimatorPair MakeEstimators(const EstimatorOptions& options) {
  if (options.mode == Mode::kGraph) {
    throw OptionError("mode", "found graph, this version has paper alone");
  }
  const CausalGaussianOptions gaussian = options.gaussian;
  return {[gaussian](const SceneModel& scene) {
            return MakeCausalGaussian(scene, gaussian);
          },
          nullptr};
}

}  // namespace kinegraph
