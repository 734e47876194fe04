// Options of the filters that smooth a joint's points, tables [filters] and
// [gaussian].
#ifndef KINEGRAPH_SOLVERS_FILTERS_OPTIONS_H_
#define KINEGRAPH_SOLVERS_FILTERS_OPTIONS_H_

#include <cstdint>

#include "core/base/options.h"
#include "solvers/factors/loss_kind.h"
#include "solvers/graph/options.h"

namespace kinegraph {

enum class PointKind {
  // The initial pose: DLT of the joints that pass the tracker's epipolar
  // filter.
  kDlt,
  kRobust,  // robust triangulation of the frame's own views, all of them
};

// Signals that share a cut-off chosen by a rule.
enum class CutoffPer {
  kAxis,
  kJoint,  // the three axes of a joint
  kBody,   // all joints of a person: the median over joints
};

// How samples become signals; the same for every filter.
struct OfflineFilterOptions {
  // Longest time between two samples of a joint that is bridged [s]: twice the
  // default of graph.bridging_limit_s, which extends into a gap from both ends.
  double max_gap_s = 1.0;
  CutoffPer cutoff_per = CutoffPer::kJoint;

  // Part of the table [filters].
  void Describe(OptionVisitor& visitor);
};

struct RobustTriangulationOptions {
  double loss_scale = 3.0;  // in sigmas

  // The following are not configuration keys; they are set in code only.
  LossKind loss = LossKind::kGemanMcClure;
  // Convergence limit [m]. Steps shrink quadratically; a caller that only needs
  // a start for another loss may use a larger limit.
  double last_step_m = 1e-6;

  // Table [filters.robust_triangulation].
  void Describe(OptionVisitor& visitor);
};

struct CentredGaussianOptions {
  double sigma_s = 0.04;

  // Table [filters.centred_gaussian].
  void Describe(OptionVisitor& visitor);
};

// Which values a window contains. Time may be non-uniform; at the ends there
// are fewer values.
enum class WindowSide {
  kCentred,   // at most half the window away
  kTrailing,  // the value itself and earlier values less than the window away
};

struct HampelMedianOptions {
  double hampel_window_s = 0.28;  // 7 frames at 25 Hz
  double hampel_threshold = 3.0;  // in standard deviations, from the MAD
  double median_window_s = 0.2;   // 5 frames at 25 Hz
  WindowSide side = WindowSide::kCentred;

  // Table [filters.hampel_median].
  void Describe(OptionVisitor& visitor);
};

struct OneEuroOptions {
  double min_cutoff_hz = 2.0;
  double beta_per_m = 1.0;  // growth of the cut-off in Hz per m/s
  bool zero_phase = false;  // forwards, then backwards: not causal

  // Table [filters.one_euro].
  void Describe(OptionVisitor& visitor);
};

// Source of a cut-off: fixed, or a rule (cutoff.h).
enum class CutoffChoice {
  kFixed,
  kWinter,
  kChallis,
  kYu,
  kJackson,
  kGcv,
  kPower95,
  kPower99,
  kLambda,  // penalised curves only
};

enum class FilterSignal {
  kPosition,
  kSpeed,  // differences from frame to frame, then summed up again
};

// Options of butterworth and critically_damped.
struct ButterworthOptions {
  int64_t order = 2;  // of each of the two passes
  CutoffChoice choice = CutoffChoice::kFixed;
  double cutoff_hz = 6.0;  // below half the frame rate; choice "fixed"
  // true: both passes together halve the power at the cut-off. false: each pass
  // does, as in most programs.
  bool correct_cutoff = true;
  FilterSignal on = FilterSignal::kPosition;

  // Table [filters.butterworth].
  void Describe(OptionVisitor& visitor);
};

struct SavitzkyGolayOptions {
  // Rounded to an odd number of frames, at least order + 1.
  double window_s = 0.36;
  int64_t order = 3;

  // Table [filters.savitzky_golay].
  void Describe(OptionVisitor& visitor);
};

// Options of the curves of smoothing_spline, quintic_spline and whittaker.
struct SmoothingSplineOptions {
  CutoffChoice choice = CutoffChoice::kGcv;
  double cutoff_hz = 4.0;  // amplitude halved; choice "cutoff"
  // Weight of the roughness for samples one frame apart; choice "lambda".
  double lambda = 10.0;

  // Table [filters.smoothing_spline].
  void Describe(OptionVisitor& visitor);
};

struct WhittakerOptions {
  int64_t order = 2;                  // of the differences
  SmoothingSplineOptions smoothness;  // copied from smoothing_spline

  // Table [filters.whittaker], without the smoothness.
  void Describe(OptionVisitor& visitor);
};

struct LoessOptions {
  // Determines the number of samples to which a polynomial is fitted: window_s
  // divided by the mean step, at least degree + 2.
  double window_s = 0.4;
  int64_t degree = 2;
  int64_t iterations = 2;  // reweighted fits

  // Table [filters.loess].
  void Describe(OptionVisitor& visitor);
};

struct TrendOptions {
  // Weight of kinks [m] for samples one frame apart.
  double lambda_m = 0.1;

  // Table [filters.trend].
  void Describe(OptionVisitor& visitor);
};

enum class MotionModel {
  kConstantVelocity,      // white noise on acceleration
  kConstantAcceleration,  // white noise on jerk
};

enum class MeasurementNoise {
  kTriangulation,  // the covariance of each sample
  kConstant,       // sigma_m of the joint's class, isotropic
};

struct KalmanOptions {
  MotionModel motion = MotionModel::kConstantVelocity;
  // graph.process_noise [m^2/s^3], copied by the smoothers' factory. ModelOf
  // derives the power of either motion model from it.
  JointClassTable process_noise = GraphOptions().process_noise;
  double process_noise_scale = 1.0;
  MeasurementNoise measurement = MeasurementNoise::kTriangulation;
  JointClassTable sigma_m = {0.03, 0.03, 0.03, 0.03, 0.03,
                             0.03, 0.03, 0.03, 0.03, 0.03};

  // Table [filters.kalman].
  void Describe(OptionVisitor& visitor);
};

struct FilterOptions {
  // The points that filters smooth. The estimators raw_dlt and
  // robust_triangulation ignore this choice: each returns the points of its own
  // kind unfiltered.
  PointKind points = PointKind::kDlt;
  OfflineFilterOptions segments;
  RobustTriangulationOptions robust_triangulation;
  CentredGaussianOptions centred_gaussian;
  HampelMedianOptions hampel_median;
  OneEuroOptions one_euro;
  ButterworthOptions butterworth;  // also used by critically_damped
  SavitzkyGolayOptions savitzky_golay;
  SmoothingSplineOptions smoothing_spline;  // also used by quintic_spline
  WhittakerOptions whittaker;
  LoessOptions loess;
  TrendOptions trend;
  KalmanOptions kalman;  // also used by rts and student_t_rts

  // Table [filters], a table below it for each filter.
  void Describe(OptionVisitor& visitor);
};

enum class VelocityRule {
  kOverTime,  // mean of the last differences over the actual time between them
  // Per stored pose, regardless of gaps, as in the code of the paper's authors
  // (causal_gaussian.h).
  kPerUpdate,
};

struct CausalGaussianOptions {
  bool smooth = true;
  double sigma_frames = 0.3;        // stored poses
  double wrist_sigma_frames = 0.8;  // wrists only, not elbows
  double history_frames = 10.0;     // older stored poses are dropped
  int64_t velocity_differences = 5;
  VelocityRule velocity = VelocityRule::kOverTime;
  // A joint that is not triangulated continues with its own velocity for this
  // long, then with the mean velocity of the triangulated joints. 0:
  // indefinitely.
  double hold_frames = 10.0;

  // Table [gaussian].
  void Describe(OptionVisitor& visitor);
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FILTERS_OPTIONS_H_
