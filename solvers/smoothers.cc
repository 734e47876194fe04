#include "solvers/smoothers.h"

#include <glog/logging.h>

#include <type_traits>
#include <utility>

#include "solvers/batch/batch_estimator.h"
#include "solvers/filters/causal_gaussian.h"
#include "solvers/filters/joint_points.h"
#include "solvers/filters/offline_filter.h"
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

// A parameter that is one field of a filter's options.
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

SmootherVariant AlsoOnRobustPoints(SmootherVariant variant) {
  variant.also_on_robust_points = true;
  return variant;
}

using Causal = std::function<bool(const EstimatorOptions&)>;
bool Always(const EstimatorOptions&) { return true; }
bool Never(const EstimatorOptions&) { return false; }

// A smoother that filters points of one kind. `make_filter` gets the frame rate
// [Hz].
using MakeFilter =
    std::function<SegmentFilter(const FilterOptions&, double rate_hz)>;
EstimatorFactory OverPoints(const EstimatorOptions& options, PointKind points,
                            PointCovariances covariances,
                            MakeFilter make_filter) {
  FilterOptions filters = options.filters;
  filters.kalman.process_noise = options.graph.process_noise;
  filters.whittaker.smoothness = filters.smoothing_spline;
  return [=, noise = options.graph, filters = std::move(filters),
          make_filter = std::move(make_filter)](const SceneModel& scene) {
    return MakeOfflineFilter(scene, filters.segments,
                             JointPoints(scene, points, covariances,
                                         filters.robust_triangulation, noise),
                             make_filter(filters, scene.frame_rate_hz));
  };
}

// A smoother over the points that filters.points selects. `make_filter` creates
// the filter from its options and, if it has these parameters, the frame rate
// [Hz] and filters.cutoff_per.
template <typename Options, typename Make>
Smoother Filter(OutputKind kind, std::string name, Causal causal,
                Options FilterOptions::*filter, Make make_filter,
                std::vector<SmootherVariant> variants) {
  const auto make = [=](const EstimatorOptions& options,
                        const std::shared_ptr<RecordingNotes>&) {
    // Only filters with KalmanOptions use the points' covariances, if
    // configured.
    bool with_covariances = false;
    if constexpr (std::is_same_v<Options, KalmanOptions>) {
      with_covariances = options.filters.kalman.measurement ==
                         MeasurementNoise::kTriangulation;
    }
    return OverPoints(
        options, options.filters.points,
        with_covariances ? PointCovariances::kOn : PointCovariances::kOff,
        [=](const FilterOptions& filters, [[maybe_unused]] double rate_hz) {
          if constexpr (std::is_invocable_v<Make, const Options&, double,
                                            CutoffPer>) {
            return make_filter(filters.*filter, rate_hz,
                               filters.segments.cutoff_per);
          } else if constexpr (std::is_invocable_v<Make, const Options&,
                                                   double>) {
            return make_filter(filters.*filter, rate_hz);
          } else {
            return make_filter(filters.*filter);
          }
        });
  };
  return {kind, std::move(name), std::move(causal), make, std::move(variants)};
}

// Points of one kind, unfiltered.
Smoother Points(OutputKind kind, std::string name, PointKind points,
                PointCovariances covariances,
                std::vector<SmootherVariant> variants) {
  const auto make = [=](const EstimatorOptions& options,
                        const std::shared_ptr<RecordingNotes>&) {
    return OverPoints(options, points, covariances,
                      [covariances](const FilterOptions&, double) {
                        return PointsAsTheyAre(covariances);
                      });
  };
  return {kind, std::move(name), Always, make, std::move(variants)};
}

// Smoothers that triangulate each frame separately, and the causal Gaussian of
// paper mode.
std::vector<Smoother> OfSingleFrames() {
  const auto gaussian =
      [](const EstimatorOptions& options,
         const std::shared_ptr<RecordingNotes>&) -> EstimatorFactory {
    return [gaussian = options.gaussian](const SceneModel& scene) {
      return MakeCausalGaussian(scene, gaussian);
    };
  };
  return {
      Points(OutputKind::kRawDlt, "raw_dlt", PointKind::kDlt,
             PointCovariances::kOff, {Variant("raw_dlt", "raw DLT")}),
      Points(OutputKind::kRobustTriangulation, "robust_triangulation",
             PointKind::kRobust, PointCovariances::kOn,
             {Variant(
                 "robust_triangulation", "robust triangulation, each frame",
                 {Field("loss_scale", "sigmas", {1.0, 2.0, 3.0, 4.5, 7.0, 10.0},
                        &FilterOptions::robust_triangulation,
                        &RobustTriangulationOptions::loss_scale)})}),
      {OutputKind::kGaussian,
       "gaussian",
       Always,
       gaussian,
       {Variant("causal_gaussian", "causal Gaussian (paper)",
                {Field("sigma_frames", "frames", {0.15, 0.3, 0.6, 0.8, 1.2},
                       [](EstimatorOptions& o) -> double& {
                         return o.gaussian.sigma_frames;
                       }),
                 Field("wrist_sigma_frames", "frames", {0.3, 0.8, 1.2},
                       [](EstimatorOptions& o) -> double& {
                         return o.gaussian.wrist_sigma_frames;
                       })})}}};
}

// Filters whose output depends mainly on a few neighbouring samples.
std::vector<Smoother> OfFewSamples() {
  using F = FilterOptions;
  const Causal trailing = [](const EstimatorOptions& options) {
    return options.filters.hampel_median.side == WindowSide::kTrailing;
  };
  const Causal forwards = [](const EstimatorOptions& options) {
    return !options.filters.one_euro.zero_phase;
  };
  const auto one_euro = [](std::string name, std::string title,
                           bool zero_phase) {
    return Variant(std::move(name), std::move(title),
                   {Field("min_cutoff_hz", "Hz", {1.0, 2.0, 4.0, 8.0, 16.0},
                          &F::one_euro, &OneEuroOptions::min_cutoff_hz),
                    Field("beta_per_m", "1/m", {1.0, 3.0, 10.0, 30.0, 100.0},
                          &F::one_euro, &OneEuroOptions::beta_per_m)},
                   [zero_phase](double, EstimatorOptions* options) {
                     options->filters.one_euro.zero_phase = zero_phase;
                   });
  };
  return {
      Filter(
          OutputKind::kCentredGaussian, "centred_gaussian", Never,
          &F::centred_gaussian, CentredGaussianFilter,
          {Variant("centred_gaussian", "centred Gaussian",
                   {Field("sigma_s", "s", {0.01, 0.02, 0.04, 0.06, 0.09, 0.14},
                          &F::centred_gaussian,
                          &CentredGaussianOptions::sigma_s)})}),
      Filter(OutputKind::kHampelMedian, "hampel_median", trailing,
             &F::hampel_median, HampelMedianFilter,
             {Variant("hampel_median", "Hampel and moving median",
                      {Field("median_window_s", "s",
                             {0.04, 0.12, 0.2, 0.28, 0.44}, &F::hampel_median,
                             &HampelMedianOptions::median_window_s),
                       Field("hampel_threshold", "sigmas", {2.0, 3.0},
                             &F::hampel_median,
                             &HampelMedianOptions::hampel_threshold)})}),
      Filter(OutputKind::kOneEuro, "one_euro", forwards, &F::one_euro,
             OneEuroFilter,
             {one_euro("one_euro", "One-Euro", false),
              one_euro("one_euro_zero_phase", "One-Euro, zero phase", true)}),
      Filter(OutputKind::kLoess, "loess", Never, &F::loess, LoessFilter,
             {Variant("loess", "LOESS",
                      {Field("window_s", "s", {0.2, 0.28, 0.4, 0.6, 0.9, 1.3},
                             &F::loess, &LoessOptions::window_s)})})};
}

// A low-pass filter with its cut-off as the parameter.
SmootherVariant AtCutoff(std::string name, std::string title,
                         FilterSignal on = FilterSignal::kPosition) {
  return Variant(
      std::move(name), std::move(title),
      {Field("cutoff_hz", "Hz", {1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0},
             &FilterOptions::butterworth, &ButterworthOptions::cutoff_hz)},
      [on](double, EstimatorOptions* options) {
        options->filters.butterworth.choice = CutoffChoice::kFixed;
        options->filters.butterworth.on = on;
      });
}

// A curve that balances misfit against roughness by cross-validation.
SmootherVariant ByGcv(std::string name, std::string title) {
  return Variant(std::move(name), std::move(title), {},
                 [](double, EstimatorOptions* options) {
                   options->filters.smoothing_spline.choice =
                       CutoffChoice::kGcv;
                 });
}

// Low-pass filters without phase shift and curves fitted to the whole signal.
std::vector<Smoother> OfWholeSignals() {
  using F = FilterOptions;
  return {
      Filter(
          OutputKind::kButterworth, "butterworth", Never, &F::butterworth,
          ButterworthFilter,
          {AlsoOnRobustPoints(
               AtCutoff("butterworth", "Butterworth, zero phase")),
           Variant("butterworth_residual", "Butterworth, residual analysis", {},
                   [](double, EstimatorOptions* options) {
                     options->filters.butterworth.choice =
                         CutoffChoice::kWinter;
                     options->filters.butterworth.on = FilterSignal::kPosition;
                   }),
           AtCutoff("butterworth_speed", "Butterworth on speed",
                    FilterSignal::kSpeed)}),
      Filter(OutputKind::kCriticallyDamped, "critically_damped", Never,
             &F::butterworth, CriticallyDampedFilter,
             {AtCutoff("critically_damped", "critically damped, zero phase")}),
      Filter(
          OutputKind::kSavitzkyGolay, "savitzky_golay", Never,
          &F::savitzky_golay, SavitzkyGolayFilter,
          {Variant(
              "savitzky_golay", "Savitzky-Golay",
              {Field("window_s", "s", {0.2, 0.28, 0.36, 0.52, 0.76, 1.0},
                     &F::savitzky_golay, &SavitzkyGolayOptions::window_s)})}),
      Filter(OutputKind::kSmoothingSpline, "smoothing_spline", Never,
             &F::smoothing_spline, SmoothingSplineFilter,
             {ByGcv("gcv_spline", "smoothing spline, GCV")}),
      Filter(OutputKind::kQuinticSpline, "quintic_spline", Never,
             &F::smoothing_spline, QuinticSplineFilter,
             {ByGcv("quintic_spline", "quintic spline, GCV")}),
      Filter(OutputKind::kWhittaker, "whittaker", Never, &F::whittaker,
             WhittakerFilter, {ByGcv("whittaker", "Whittaker-Henderson, GCV")}),
      Filter(OutputKind::kTrend, "trend", Never, &F::trend, TrendPointFilter,
             {Variant("trend", "l1 trend filtering",
                      {Field("lambda_m", "m", {0.01, 0.03, 0.1, 0.3, 1.0, 3.0},
                             &F::trend, &TrendOptions::lambda_m)})})};
}

// State-space filters.
std::vector<Smoother> OfStates() {
  const auto with_motion = [](std::string name, std::string title,
                              MotionModel model) {
    return Variant(
        std::move(name), std::move(title),
        {Field("process_noise_factor", "",
               {0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0},
               &FilterOptions::kalman, &KalmanOptions::process_noise_scale)},
        [model](double, EstimatorOptions* options) {
          options->filters.kalman.motion = model;
        });
  };
  return {
      Filter(OutputKind::kKalman, "kalman", Always, &FilterOptions::kalman,
             KalmanPointFilter,
             {with_motion("kalman_cv", "Kalman, constant velocity",
                          MotionModel::kConstantVelocity),
              with_motion("kalman_ca", "Kalman, constant acceleration",
                          MotionModel::kConstantAcceleration)}),
      Filter(OutputKind::kRts, "rts", Never, &FilterOptions::kalman,
             RtsPointSmoother,
             {AlsoOnRobustPoints(with_motion("rts_cv", "RTS, constant velocity",
                                             MotionModel::kConstantVelocity)),
              with_motion("rts_ca", "RTS, constant acceleration",
                          MotionModel::kConstantAcceleration)}),
      Filter(OutputKind::kStudentTRts, "student_t_rts", Never,
             &FilterOptions::kalman, StudentTPointSmoother,
             {with_motion("student_t_rts", "RTS, Student's t",
                          MotionModel::kConstantVelocity)})};
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

// The variant that learns noise and, if it has bones, their variability from
// the recording, as `track` does by default; it has no parameters.
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

// `make` creates an estimator of the graph.
Smoother OverGraph(
    OutputKind kind, std::string name,
    std::unique_ptr<Estimator> (*make)(const SceneModel&, const GraphOptions&,
                                       std::shared_ptr<RecordingNotes>),
    std::vector<SmootherVariant> variants) {
  const auto factory =
      [make](const EstimatorOptions& options,
             std::shared_ptr<RecordingNotes> notes) -> EstimatorFactory {
    return [make, graph = options.graph, notes = std::move(notes)](
               const SceneModel& scene) { return make(scene, graph, notes); };
  };
  return {kind, std::move(name), Never, factory, std::move(variants)};
}

std::vector<Smoother> OfTheGraph() {
  std::vector<SmootherVariant> windows;
  for (const int lag : {0, 3, 5, 10, 20, 30}) windows.push_back(WindowOf(lag));
  windows.push_back(ThatLearns(WindowOf(10)));
  const SmootherVariant plain =
      BatchOf("batch", "batch", Bones::kOff, GraphLossScale());
  const SmootherVariant bones = BatchOf(
      "batch_bones", "batch with bones", Bones::kOn,
      Field(
          "bone_sigma_m", "m", {0.01, 0.02, 0.04},
          [](EstimatorOptions& o) -> double& { return o.graph.bone_sigma_m; }));
  return {OverGraph(OutputKind::kWindow, "window", MakeWindowEstimator,
                    std::move(windows)),
          OverGraph(OutputKind::kBatch, "batch", MakeBatchEstimator,
                    {plain, bones, ThatLearns(plain), ThatLearns(bones)})};
}

}  // namespace

const std::vector<Smoother>& Smoothers() {
  static const std::vector<Smoother> smoothers = [] {
    std::vector<Smoother> all;
    for (const auto group :
         {OfSingleFrames, OfFewSamples, OfWholeSignals, OfStates, OfTheGraph}) {
      for (Smoother& one : group()) all.push_back(std::move(one));
    }
    return all;
  }();
  return smoothers;
}

const Smoother& SmootherOf(OutputKind kind) {
  const Smoother& smoother = Smoothers().at(static_cast<size_t>(kind));
  CHECK(smoother.kind == kind)
      << smoother.name << " is not in the order of OutputKind";
  return smoother;
}

}  // namespace kinegraph
