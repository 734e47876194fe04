#include "solvers/smoothers.h"

#include <glog/logging.h>

#include <type_traits>
#include <utility>

#include "solvers/batch/batch_estimator.h"
#include "solvers/filters/causal_gaussian.h"
#include "solvers/filters/joint_points.h"
#include "solvers/filters/offline_filter.h"
#include "solvers/graph/assembler.h"
#include "solvers/noise/recording_notes.h"
#include "solvers/window/window_estimator.h"

namespace kinegraph {
namespace {

using Parameters = std::vector<SmootherParameter>;
using Fix = std::function<void(double, EstimatorOptions*)>;

// A parameter that is one field of the options.
template <typename Access>
SmootherParameter Field(std::string name, std::string unit,
                        std::vector<double> grid, Access access) {
  SmootherParameter parameter;
  parameter.name = std::move(name);
  parameter.unit = std::move(unit);
  parameter.log = grid.front() > 0.0 && grid.back() / grid.front() >= 8.0;
  parameter.grid = std::move(grid);
  parameter.set = [access](double value, EstimatorOptions* options) {
    access(*options) = value;
  };
  parameter.get = [access](const EstimatorOptions& options) {
    EstimatorOptions copy = options;
    return access(copy);
  };
  return parameter;
}

// One of the options of a filter.
template <typename Options>
SmootherParameter Field(std::string name, std::string unit,
                        std::vector<double> grid,
                        Options FilterOptions::*filter,
                        double Options::*field) {
  return Field(std::move(name), std::move(unit), std::move(grid),
               [=](EstimatorOptions& options) -> double& {
                 return options.filters.*filter.*field;
               });
}

SmootherVariant Variant(std::string name, std::string title,
                        Parameters parameters = {}, Fix fix = nullptr) {
  SmootherVariant variant;
  variant.name = std::move(name);
  variant.title = std::move(title);
  variant.fix = std::move(fix);
  variant.parameters = std::move(parameters);
  return variant;
}

bool Always(const EstimatorOptions&) { return true; }
bool Never(const EstimatorOptions&) { return false; }

// A smoother that filters the points of one kind. `make_filter` gets the frame
// rate [Hz].
using MakeFilter =
    std::function<SegmentFilter(const FilterOptions&, double rate_hz)>;
EstimatorFactory OverPoints(const EstimatorOptions& options, PointKind points,
                            PointCovariances covariances,
                            MakeFilter make_filter) {
  const PixelSigmaOf sigma_of = [graph = options.graph](
                                    JointClass joint_class, double confidence,
                                    double depth_m, double focal_px) {
    return PixelSigma(graph, joint_class, confidence, depth_m, focal_px);
  };
  FilterOptions filters = options.filters;
  filters.kalman.process_noise = options.graph.process_noise;
  return [=, filters = std::move(filters),
          make_filter = std::move(make_filter)](const SceneModel& scene) {
    return MakeOfflineFilter(
        scene, filters.segments,
        JointPoints(scene, points, covariances, filters.robust_triangulation,
                    sigma_of),
        make_filter(filters, scene.frame_rate_hz));
  };
}

// A smoother over the points that filters.points names. `make_filter` makes it
// from its options, and the frame rate [Hz] where it asks for it.
template <typename Options, typename Make>
Smoother Filter(OutputKind kind, std::string name,
                Options FilterOptions::*filter, Make make_filter) {
  Smoother smoother;
  smoother.kind = kind;
  smoother.name = std::move(name);
  smoother.causal = Never;
  smoother.make = [=](const EstimatorOptions& options,
                      const std::shared_ptr<RecordingNotes>&) {
    // Only Kalman's take the points' covariances, where they are asked for.
    bool with_covariances = false;
    if constexpr (std::is_same_v<Options, KalmanOptions>) {
      with_covariances = options.filters.kalman.measurement ==
                         MeasurementNoise::kTriangulation;
    }
    return OverPoints(
        options, options.filters.points,
        with_covariances ? PointCovariances::kOn : PointCovariances::kOff,
        [=](const FilterOptions& filters, [[maybe_unused]] double rate_hz) {
          if constexpr (std::is_invocable_v<Make, const Options&, double>) {
            return make_filter(filters.*filter, rate_hz);
          } else {
            return make_filter(filters.*filter);
          }
        });
  };
  return smoother;
}

// ---- Each frame by itself, and what is written in paper mode ----------------

// Points of one kind as they are.
Smoother Points(OutputKind kind, std::string name, PointKind points,
                PointCovariances covariances) {
  Smoother smoother;
  smoother.kind = kind;
  smoother.name = std::move(name);
  smoother.causal = Always;
  smoother.make = [=](const EstimatorOptions& options,
                      const std::shared_ptr<RecordingNotes>&) {
    return OverPoints(options, points, covariances,
                      [covariances](const FilterOptions&, double) {
                        return PointsAsTheyAre(covariances);
                      });
  };
  return smoother;
}

Smoother RawDlt() {
  Smoother smoother = Points(OutputKind::kRawDlt, "raw_dlt", PointKind::kDlt,
                             PointCovariances::kOff);
  smoother.variants = {Variant("raw_dlt", "raw DLT")};
  return smoother;
}

Smoother RobustTriangulation() {
  Smoother smoother =
      Points(OutputKind::kRobustTriangulation, "robust_triangulation",
             PointKind::kRobust, PointCovariances::kOn);
  smoother.variants = {
      Variant("robust_triangulation", "robust triangulation, each frame",
              {Field("loss_scale", "sigmas", {1.0, 2.0, 3.0, 4.5, 7.0, 10.0},
                     &FilterOptions::robust_triangulation,
                     &RobustTriangulationOptions::loss_scale)})};
  return smoother;
}

Smoother Gaussian() {
  Smoother smoother;
  smoother.kind = OutputKind::kGaussian;
  smoother.name = "gaussian";
  smoother.causal = Always;
  smoother.make =
      [](const EstimatorOptions& options,
         const std::shared_ptr<RecordingNotes>&) -> EstimatorFactory {
    return [gaussian = options.gaussian](const SceneModel& scene) {
      return MakeCausalGaussian(scene, gaussian);
    };
  };
  smoother.variants = {
      Variant("causal_gaussian", "causal Gaussian (paper)",
              {Field("sigma_frames", "frames", {0.15, 0.3, 0.6, 0.8, 1.2},
                     [](EstimatorOptions& o) -> double& {
                       return o.gaussian.sigma_frames;
                     }),
               Field("wrist_sigma_frames", "frames", {0.3, 0.8, 1.2},
                     [](EstimatorOptions& o) -> double& {
                       return o.gaussian.wrist_sigma_frames;
                     })})};
  return smoother;
}

// ---- A few samples at once, along the signal --------------------------------

Smoother CentredGaussian() {
  Smoother smoother =
      Filter(OutputKind::kCentredGaussian, "centred_gaussian",
             &FilterOptions::centred_gaussian, CentredGaussianFilter);
  smoother.variants = {
      Variant("centred_gaussian", "centred Gaussian",
              {Field("sigma_s", "s", {0.01, 0.02, 0.04, 0.06, 0.09, 0.14},
                     &FilterOptions::centred_gaussian,
                     &CentredGaussianOptions::sigma_s)})};
  return smoother;
}

Smoother HampelMedian() {
  Smoother smoother = Filter(OutputKind::kHampelMedian, "hampel_median",
                             &FilterOptions::hampel_median, HampelMedianFilter);
  smoother.causal = [](const EstimatorOptions& options) {
    return options.filters.hampel_median.side == WindowSide::kTrailing;
  };
  smoother.variants = {
      Variant("hampel_median", "Hampel and moving median",
              {Field("median_window_s", "s", {0.04, 0.12, 0.2, 0.28, 0.44},
                     &FilterOptions::hampel_median,
                     &HampelMedianOptions::median_window_s),
               Field("hampel_threshold", "sigmas", {2.0, 3.0},
                     &FilterOptions::hampel_median,
                     &HampelMedianOptions::hampel_threshold)})};
  return smoother;
}

Smoother OneEuro() {
  Smoother smoother = Filter(OutputKind::kOneEuro, "one_euro",
                             &FilterOptions::one_euro, OneEuroFilter);
  smoother.causal = Always;
  smoother.variants = {
      Variant("one_euro", "One-Euro",
              {Field("min_cutoff_hz", "Hz", {1.0, 2.0, 4.0, 8.0, 16.0},
                     &FilterOptions::one_euro, &OneEuroOptions::min_cutoff_hz),
               Field("beta_per_m", "1/m", {1.0, 3.0, 10.0, 30.0, 100.0},
                     &FilterOptions::one_euro, &OneEuroOptions::beta_per_m)})};
  return smoother;
}

// ---- The whole signal at once, without delay --------------------------------

Smoother Butterworth() {
  Smoother smoother = Filter(OutputKind::kButterworth, "butterworth",
                             &FilterOptions::butterworth, ButterworthFilter);
  smoother.variants = {
      Variant(
          "butterworth", "Butterworth, zero phase",
          {Field("cutoff_hz", "Hz", {1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0},
                 &FilterOptions::butterworth, &ButterworthOptions::cutoff_hz)},
          [](double, EstimatorOptions* options) {
            options->filters.butterworth.choice = CutoffChoice::kFixed;
          }),
      Variant("butterworth_residual", "Butterworth, residual analysis", {},
              [](double, EstimatorOptions* options) {
                options->filters.butterworth.choice =
                    CutoffChoice::kResidualAnalysis;
              })};
  smoother.variants.front().also_on_robust_points = true;
  return smoother;
}

Smoother SavitzkyGolay() {
  Smoother smoother =
      Filter(OutputKind::kSavitzkyGolay, "savitzky_golay",
             &FilterOptions::savitzky_golay, SavitzkyGolayFilter);
  smoother.variants = {
      Variant("savitzky_golay", "Savitzky-Golay",
              {Field("window_s", "s", {0.2, 0.28, 0.36, 0.52, 0.76, 1.0},
                     &FilterOptions::savitzky_golay,
                     &SavitzkyGolayOptions::window_s)})};
  return smoother;
}

Smoother SmoothingSpline() {
  Smoother smoother =
      Filter(OutputKind::kSmoothingSpline, "smoothing_spline",
             &FilterOptions::smoothing_spline, SmoothingSplineFilter);
  smoother.variants = {Variant("gcv_spline", "smoothing spline, GCV", {},
                               [](double, EstimatorOptions* options) {
                                 options->filters.smoothing_spline.choice =
                                     SmoothnessChoice::kGcv;
                               })};
  return smoother;
}

// ---- A state along time -----------------------------------------------------

SmootherVariant WithMotion(std::string name, std::string title,
                           MotionModel model) {
  return Variant(
      std::move(name), std::move(title),
      {Field("process_noise_factor", "",
             {0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0},
             &FilterOptions::kalman, &KalmanOptions::process_noise_scale)},
      [model](double, EstimatorOptions* options) {
        options->filters.kalman.motion = model;
      });
}

Smoother Kalman() {
  Smoother smoother = Filter(OutputKind::kKalman, "kalman",
                             &FilterOptions::kalman, KalmanPointFilter);
  smoother.causal = Always;
  smoother.variants = {WithMotion("kalman_cv", "Kalman, constant velocity",
                                  MotionModel::kConstantVelocity),
                       WithMotion("kalman_ca", "Kalman, constant acceleration",
                                  MotionModel::kConstantAcceleration)};
  return smoother;
}

Smoother Rts() {
  Smoother smoother =
      Filter(OutputKind::kRts, "rts", &FilterOptions::kalman, RtsPointSmoother);
  smoother.variants = {WithMotion("rts_cv", "RTS, constant velocity",
                                  MotionModel::kConstantVelocity),
                       WithMotion("rts_ca", "RTS, constant acceleration",
                                  MotionModel::kConstantAcceleration)};
  smoother.variants.front().also_on_robust_points = true;
  return smoother;
}

// ---- The factor graph -------------------------------------------------------

// One factor on the whole table of process noise, which is then not learnt.
SmootherParameter GraphProcessNoise() {
  SmootherParameter parameter;
  parameter.name = "process_noise_factor";
  parameter.grid = {0.1, 0.3, 1.0, 3.0, 10.0, 30.0};
  parameter.log = true;
  parameter.set = [](double value, EstimatorOptions* options) {
    for (double& q : options->graph.process_noise) q *= value;
    options->graph.process_noise_from = NoiseFrom::kFixed;
  };
  parameter.get = [](const EstimatorOptions&) { return 1.0; };
  return parameter;
}

SmootherParameter GraphLossScale() {
  return Field(
      "loss_scale", "sigmas", {2.0, 3.0, 4.5, 7.0},
      [](EstimatorOptions& o) -> double& { return o.graph.loss_scale; });
}

// What `track` runs when nothing is said: noise and bones as the recording
// shows them. Nothing to tune.
SmootherVariant ThatLearns(SmootherVariant variant) {
  variant.name += "_take";
  variant.title += ", noise learnt";
  variant.parameters.clear();
  variant.tuned_as.clear();
  variant.fix = [fix = std::move(variant.fix)](double rate_hz,
                                               EstimatorOptions* options) {
    fix(rate_hz, options);
    options->graph.pixel_noise_from = NoiseFrom::kRecording;
    options->graph.process_noise_from = NoiseFrom::kRecording;
    options->graph.bone_sigma_from = NoiseFrom::kRecording;
  };
  return variant;
}

SmootherVariant WindowOf(int lag_frames) {
  SmootherVariant variant =
      Variant("window_" + std::to_string(lag_frames),
              "window, " + std::to_string(lag_frames) + " frames",
              {GraphProcessNoise(), GraphLossScale()},
              [lag_frames](double rate_hz, EstimatorOptions* options) {
                options->graph.lag_s = lag_frames / rate_hz;
                options->graph.bones = false;
              });
  variant.lag_frames = lag_frames;
  variant.tuned_as = "batch";
  return variant;
}

Smoother Window() {
  Smoother smoother;
  smoother.kind = OutputKind::kWindow;
  smoother.name = "window";
  smoother.causal = Never;
  smoother.make =
      [](const EstimatorOptions& options,
         std::shared_ptr<RecordingNotes> notes) -> EstimatorFactory {
    return [graph = options.graph,
            notes = std::move(notes)](const SceneModel& scene) {
      return MakeWindowEstimator(scene, graph, notes);
    };
  };
  for (const int lag : {0, 3, 5, 10, 20, 30}) {
    smoother.variants.push_back(WindowOf(lag));
  }
  smoother.variants.push_back(ThatLearns(WindowOf(10)));
  return smoother;
}

enum class Bones { kOff, kOn };

SmootherVariant BatchOf(std::string name, std::string title, Bones bones,
                        SmootherParameter second) {
  return Variant(std::move(name), std::move(title),
                 {GraphProcessNoise(), std::move(second)},
                 [bones](double, EstimatorOptions* options) {
                   options->graph.bones = bones == Bones::kOn;
                   options->graph.bone_sigma_from = NoiseFrom::kFixed;
                 });
}

Smoother Batch() {
  Smoother smoother;
  smoother.kind = OutputKind::kBatch;
  smoother.name = "batch";
  smoother.causal = Never;
  smoother.make =
      [](const EstimatorOptions& options,
         std::shared_ptr<RecordingNotes> notes) -> EstimatorFactory {
    return [graph = options.graph,
            notes = std::move(notes)](const SceneModel& scene) {
      return MakeBatchEstimator(scene, graph, notes);
    };
  };
  const SmootherVariant plain =
      BatchOf("batch", "batch", Bones::kOff, GraphLossScale());
  const SmootherVariant bones = BatchOf(
      "batch_bones", "batch with bones", Bones::kOn,
      Field(
          "bone_sigma_m", "m", {0.01, 0.02, 0.04},
          [](EstimatorOptions& o) -> double& { return o.graph.bone_sigma_m; }));
  smoother.variants = {plain, bones, ThatLearns(plain), ThatLearns(bones)};
  return smoother;
}

}  // namespace

const std::vector<Smoother>& Smoothers() {
  static const std::vector<Smoother> smoothers = {RawDlt(),
                                                  RobustTriangulation(),
                                                  Gaussian(),
                                                  CentredGaussian(),
                                                  HampelMedian(),
                                                  OneEuro(),
                                                  Butterworth(),
                                                  SavitzkyGolay(),
                                                  SmoothingSpline(),
                                                  Kalman(),
                                                  Rts(),
                                                  Window(),
                                                  Batch()};
  return smoothers;
}

const Smoother& SmootherOf(OutputKind kind) {
  const Smoother& smoother = Smoothers().at(static_cast<size_t>(kind));
  CHECK(smoother.kind == kind) << smoother.name << " stands at a wrong place";
  return smoother;
}

}  // namespace kinegraph
