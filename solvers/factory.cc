#include "solvers/factory.h"

#include <utility>

#include "solvers/noise/recording_notes.h"
#include "solvers/smoothers.h"

namespace kinegraph {

const char* ToString(Mode mode) {
  return mode == Mode::kPaper ? "paper" : "graph";
}

const std::vector<std::string>& OutputNames() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const Smoother& one : Smoothers()) all.push_back(one.name);
    return all;
  }();
  return names;
}

void EstimatorOptions::Describe(OptionVisitor& visitor) {
  visitor.Choice("mode", &mode, {"paper", "graph"},
                 "the paper's tracking rules and estimator, or kinegraph's "
                 "(output.estimator)");
  visitor.Enter("tracking");
  visitor.Choice("feedback", &feedback, {"gaussian", "window"},
                 "graph mode: the estimator that serves association");
  visitor.Leave();
  visitor.Enter("output");
  visitor.Choice("estimator", &output, OutputNames(),
                 "graph mode: the estimator whose poses are written");
  visitor.Leave();
  visitor.Enter("gaussian");
  gaussian.Describe(visitor);
  visitor.Leave();
  graph.Describe(visitor);
  filters.Describe(visitor);
}

bool IsCausal(OutputKind kind, const EstimatorOptions& options) {
  return SmootherOf(kind).causal(options);
}

EstimatorFactory MakeOutput(OutputKind kind, const EstimatorOptions& options,
                            std::shared_ptr<RecordingNotes> notes) {
  if (notes == nullptr) notes = std::make_shared<RecordingNotes>(options.graph);
  CheckOptions(options.filters);
  return SmootherOf(kind).make(options, std::move(notes));
}

EstimatorPair MakeEstimators(const EstimatorOptions& options) {
  if (options.mode == Mode::kPaper) {
    return {SmootherOf(OutputKind::kGaussian).make(options, nullptr), nullptr,
            nullptr};
  }
  const OutputKind feedback = options.feedback == FeedbackKind::kWindow
                                  ? OutputKind::kWindow
                                  : OutputKind::kGaussian;
  const bool same = feedback == options.output;  // one estimator in both roles
  EstimatorPair pair;
  pair.notes = std::make_shared<RecordingNotes>(options.graph);
  // New notes for every pair: people of different runs must not learn from each
  // other. `pair.notes` are those of the estimator whose poses are written; a
  // feedback estimator of another kind gets none, and each of its people learns
  // alone.
  pair.feedback =
      SmootherOf(feedback).make(options, same ? pair.notes : nullptr);
  if (!same) pair.output = MakeOutput(options.output, options, pair.notes);
  return pair;
}

}  // namespace kinegraph
