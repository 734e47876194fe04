#include "solvers/factory.h"

#include <glog/logging.h>

#include <functional>
#include <utility>

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

// `make_filter` gets the frame rate [Hz].
EstimatorFactory Offline(const FilterOptions& options,
                         std::function<SegmentFilter(double)> make_filter) {
  return [segments = options.segments,
          make_filter = std::move(make_filter)](const SceneModel& scene) {
    return MakeOfflineFilter(scene, segments, make_filter(scene.frame_rate_hz));
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

const std::vector<std::string>& OutputNames() {
  static const std::vector<std::string> kNames = {
      "window",           "batch",      "gaussian", "raw_dlt",
      "centred_gaussian", "butterworth"};
  return kNames;
}

bool IsCausal(OutputKind kind) {
  return kind == OutputKind::kGaussian || kind == OutputKind::kRawDlt;
}

void EstimatorOptions::Describe(OptionVisitor& visitor) {
  visitor.Choice("mode", &mode, {"paper", "graph"},
                 "the pair of estimators: the paper's, or the factor graph");
  visitor.Enter("tracking");
  visitor.Choice("feedback", &feedback, {"gaussian", "window"},
                 "graph mode: the estimator that serves association");
  visitor.Leave();
  visitor.Enter("output");
  visitor.Choice("estimator", &output, OutputNames(),
                 "graph mode: the estimator that is written");
  visitor.Leave();
  visitor.Enter("gaussian");
  gaussian.Describe(visitor);
  visitor.Leave();
  graph.Describe(visitor);
  filters.Describe(visitor);
}

EstimatorFactory MakeOutput(OutputKind kind, const EstimatorOptions& options) {
  const FilterOptions& filters = options.filters;
  CheckOptions(filters);
  switch (kind) {
    case OutputKind::kWindow:
      return Window(options.graph);
    case OutputKind::kBatch:
      return Batch(options.graph);
    case OutputKind::kGaussian:
      return Gaussian(options.gaussian);
    case OutputKind::kRawDlt:
      return Offline(filters, [](double) { return RawFilter(); });
    case OutputKind::kCentredGaussian:
      return Offline(filters, [o = filters.centred_gaussian](double) {
        return CentredGaussianFilter(o);
      });
    case OutputKind::kButterworth:
      return Offline(filters, [o = filters.butterworth](double rate_hz) {
        return ButterworthFilter(o, rate_hz);
      });
  }
  LOG(FATAL) << "unknown estimator";
  return nullptr;
}

EstimatorPair MakeEstimators(const EstimatorOptions& options) {
  if (options.mode == Mode::kPaper)
    return {Gaussian(options.gaussian), nullptr};
  EstimatorPair pair;
  pair.feedback = options.feedback == FeedbackKind::kWindow
                      ? Window(options.graph)
                      : Gaussian(options.gaussian);
  if (!SameEstimator(options.feedback, options.output)) {
    pair.output = MakeOutput(options.output, options);
  }
  return pair;
}

}  // namespace kinegraph
