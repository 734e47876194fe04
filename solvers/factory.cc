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

// Every factory has notes of its own: who is not of the same run and pass
// learns nothing from them.
EstimatorFactory Window(const GraphOptions& options,
                        std::shared_ptr<TakeNotes> notes) {
  return [options, notes = std::move(notes)](const SceneModel& scene) {
    return MakeWindowEstimator(scene, options, notes);
  };
}

EstimatorFactory Batch(const GraphOptions& options,
                       std::shared_ptr<TakeNotes> notes) {
  return [options, notes = std::move(notes)](const SceneModel& scene) {
    return MakeBatchEstimator(scene, options, notes);
  };
}

// A filter over the points of one kind. `make_filter` gets the frame rate [Hz].
EstimatorFactory Offline(const EstimatorOptions& options, PointKind points,
                         bool covariances,
                         std::function<SegmentFilter(double)> make_filter) {
  return [=, filters = options.filters, noise = options.graph,
          make_filter = std::move(make_filter)](const SceneModel& scene) {
    return MakeOfflineFilter(scene, filters.segments,
                             JointPoints(scene, points, covariances,
                                         filters.robust_triangulation, noise),
                             make_filter(scene.frame_rate_hz));
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
  static const std::vector<std::string> kNames = {"window",
                                                  "batch",
                                                  "gaussian",
                                                  "raw_dlt",
                                                  "robust_triangulation",
                                                  "centred_gaussian",
                                                  "hampel_median",
                                                  "one_euro",
                                                  "butterworth",
                                                  "savitzky_golay",
                                                  "smoothing_spline",
                                                  "kalman",
                                                  "rts"};
  return kNames;
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

bool IsCausal(OutputKind kind, const EstimatorOptions& options) {
  switch (kind) {
    case OutputKind::kGaussian:
    case OutputKind::kRawDlt:
    case OutputKind::kRobustTriangulation:
    case OutputKind::kOneEuro:
    case OutputKind::kKalman:
      return true;
    case OutputKind::kHampelMedian:
      return options.filters.hampel_median.side == WindowSide::kTrailing;
    // All named, so that the compiler asks for whoever comes next.
    case OutputKind::kWindow:
    case OutputKind::kBatch:
    case OutputKind::kCentredGaussian:
    case OutputKind::kButterworth:
    case OutputKind::kSavitzkyGolay:
    case OutputKind::kSmoothingSpline:
    case OutputKind::kRts:
      return false;
  }
  return false;
}

EstimatorFactory MakeOutput(OutputKind kind, const EstimatorOptions& options,
                            std::shared_ptr<TakeNotes> notes) {
  if (notes == nullptr) notes = std::make_shared<TakeNotes>(options.graph);
  const FilterOptions& filters = options.filters;
  CheckOptions(filters);
  const bool covariances =
      (kind == OutputKind::kKalman || kind == OutputKind::kRts) &&
      filters.kalman.measurement == MeasurementNoise::kTriangulation;
  const auto smooth = [&](std::function<SegmentFilter(double)> make_filter) {
    return Offline(options, filters.points, covariances,
                   std::move(make_filter));
  };
  switch (kind) {
    case OutputKind::kWindow:
      return Window(options.graph, std::move(notes));
    case OutputKind::kBatch:
      return Batch(options.graph, std::move(notes));
    case OutputKind::kGaussian:
      return Gaussian(options.gaussian);
    case OutputKind::kRawDlt:
      return Offline(options, PointKind::kDlt, false,
                     [](double) { return PointsAsTheyAre(false); });
    case OutputKind::kRobustTriangulation:
      return Offline(options, PointKind::kRobust, true,
                     [](double) { return PointsAsTheyAre(true); });
    case OutputKind::kCentredGaussian:
      return smooth([filters](double) {
        return CentredGaussianFilter(filters.centred_gaussian);
      });
    case OutputKind::kHampelMedian:
      return smooth([filters](double) {
        return HampelMedianFilter(filters.hampel_median);
      });
    case OutputKind::kOneEuro:
      return smooth(
          [filters](double) { return OneEuroFilter(filters.one_euro); });
    case OutputKind::kButterworth:
      return smooth([filters](double rate_hz) {
        return ButterworthFilter(filters.butterworth, rate_hz);
      });
    case OutputKind::kSavitzkyGolay:
      return smooth([filters](double rate_hz) {
        return SavitzkyGolayFilter(filters.savitzky_golay, rate_hz);
      });
    case OutputKind::kSmoothingSpline:
      return smooth([filters](double rate_hz) {
        return SmoothingSplineFilter(filters.smoothing_spline, rate_hz);
      });
    case OutputKind::kKalman:
      return smooth(
          [filters](double) { return KalmanPointFilter(filters.kalman); });
    case OutputKind::kRts:
      return smooth(
          [filters](double) { return RtsPointSmoother(filters.kalman); });
  }
  LOG(FATAL) << "unknown estimator";
  return nullptr;
}

EstimatorPair MakeEstimators(const EstimatorOptions& options) {
  if (options.mode == Mode::kPaper)
    return {Gaussian(options.gaussian), nullptr, nullptr};
  EstimatorPair pair;
  pair.notes = std::make_shared<TakeNotes>(options.graph);
  const bool same = SameEstimator(options.feedback, options.output);
  pair.feedback = options.feedback == FeedbackKind::kWindow
                      ? Window(options.graph, same ? pair.notes : nullptr)
                      : Gaussian(options.gaussian);
  if (!same) pair.output = MakeOutput(options.output, options, pair.notes);
  return pair;
}

}  // namespace kinegraph
