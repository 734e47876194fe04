#include "solvers/factory.h"

#include "solvers/batch/batch_estimator.h"
#include "solvers/window/window_estimator.h"

namespace kinegraph {
namespace {

EstimatorFactory Gaussian(const CausalGaussianOptions& options) {
  return [options](const SceneModel& scene) {
    return MakeCausalGaussian(scene, options);
  };
}

EstimatorFactory Window(const GraphOptions& options) {
  return [options](const SceneModel& scene) {
    return MakeWindowEstimator(scene, options);
  };
}

EstimatorFactory Batch(const GraphOptions& options) {
  return [options](const SceneModel& scene) {
    return MakeBatchEstimator(scene, options);
  };
}

// Whether one estimator can serve both roles.
bool SameEstimator(FeedbackKind feedback, OutputKind output) {
  return (feedback == FeedbackKind::kGaussian &&
          output == OutputKind::kGaussian) ||
         (feedback == FeedbackKind::kWindow && output == OutputKind::kWindow);
}

}  // namespace

const char* ToString(Mode mode) {
  return mode == Mode::kPaper ? "paper" : "graph";
}

void EstimatorOptions::Describe(OptionVisitor& visitor) {
  visitor.Choice("mode", &mode, {"paper", "graph"},
                 "the pair of estimators: the paper's, or the factor graph");
  visitor.Enter("tracking");
  visitor.Choice("feedback", &feedback, {"gaussian", "window"},
                 "graph mode: the estimator that serves association");
  visitor.Leave();
  visitor.Enter("output");
  visitor.Choice("estimator", &output, {"window", "batch", "gaussian"},
                 "graph mode: the estimator that is written");
  visitor.Leave();
  visitor.Enter("gaussian");
  gaussian.Describe(visitor);
  visitor.Leave();
  graph.Describe(visitor);
}

EstimatorPair MakeEstimators(const EstimatorOptions& options) {
  if (options.mode == Mode::kPaper)
    return {Gaussian(options.gaussian), nullptr};
  EstimatorPair pair;
  pair.feedback = options.feedback == FeedbackKind::kWindow
                      ? Window(options.graph)
                      : Gaussian(options.gaussian);
  if (SameEstimator(options.feedback, options.output)) return pair;
  switch (options.output) {
    case OutputKind::kWindow:
      pair.output = Window(options.graph);
      break;
    case OutputKind::kBatch:
      pair.output = Batch(options.graph);
      break;
    case OutputKind::kGaussian:
      pair.output = Gaussian(options.gaussian);
      break;
  }
  return pair;
}

}  // namespace kinegraph
