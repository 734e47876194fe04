// Options of the factor-graph estimators, table [graph]. Independent of any
// solver.
#ifndef KINEGRAPH_SOLVERS_GRAPH_OPTIONS_H_
#define KINEGRAPH_SOLVERS_GRAPH_OPTIONS_H_

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/base/options.h"
#include "core/data/view_bias.h"
#include "core/skeleton/skeleton.h"
#include "solvers/factors/loss_kind.h"
#include "solvers/graph/general_factor.h"
#include "solvers/graph/solve_counts.h"

namespace kinegraph {

// One number per class of joints, in the order of JointClass.
using JointClassTable = std::array<double, kJointClassCount>;

// The key `name`: one number, or a table by class of joint.
void DescribeJointClasses(OptionVisitor& visitor, const std::string& name,
                          JointClassTable* table, const std::string& unit,
                          const std::string& help);

// The solver of the final estimate; both minimise the same cost.
enum class GraphSolver {
  // One Ceres problem with all factors of a person, per window or chunk.
  kCeres,
  // Block-tridiagonal elimination, with conjugate gradients for bones.
  kBlockTridiagonal,
};
// The value of the key graph.solver.
const char* ToString(GraphSolver solver);

// Where Ceres starts.
enum class GraphStart {
  kBasin,  // graduated non-convexity by block-tridiagonal elimination
  // The initial pose (DLT of the joints that pass the tracker's epipolar
  // filter); Ceres runs all stages.
  kDlt,
};

// Source of a noise parameter.
enum class NoiseFrom {
  kRecording,  // learnt from the recording itself
  kFixed,      // the values of the options
};

// Whether the detector's bias per view is learnt and subtracted.
enum class ViewBiasUse {
  kOff,
  kOn,    // wherever the recording determines it
  kAuto,  // for joints whose residuals it reduces in a held-out half
};

struct GraphOptions {
  // Time for which the window keeps states before they become final [s]; 0.4 s
  // are 10 frames at 25 Hz.
  double lag_s = 0.4;

  LossKind loss = LossKind::kGemanMcClure;
  double loss_scale = 3.0;  // in sigmas

  // Power of the white noise on acceleration [m^2/s^3].
  // head trunk shoulder elbow wrist hip knee ankle foot other
  JointClassTable process_noise = {2.0, 1.0, 1.4,  4.0,  6.0,
                                   1.0, 2.0, 10.0, 10.0, 6.0};
  // Detector error at a confidence of 1 [px], at a depth of 4 m with a focal
  // length of 1000 px. It scales with the size of the person in the image.
  JointClassTable sigma_px = {6.0, 6.0, 6.0, 6.0, 6.0, 6.0, 6.0, 6.0, 6.0, 6.0};
  double confidence_power = 0.5;  // sigma grows with confidence^-power

  // Detector errors are correlated in time: e-folding time [s], 0 for white
  // noise. The information of each observation is scaled, after the loss, by
  // information_scale (1 - rho) / (1 + rho), rho = exp(-dt / tau).
  double correlation_time_s = 0.1;
  double information_scale = 1.5;
  // One factor on all sigmas of a person, estimated from the residuals: of the
  // whole recording (batch), or of the frames final so far (window).
  bool estimate_noise_scale = true;

  // What is learnt for each person (solvers/noise). Pixel noise: the size of
  // the errors by class of joint, with sigma_px as the prior, and their
  // correlation time, so that correlation_time_s, information_scale and
  // estimate_noise_scale are not used; and the dependence on confidence
  // (solvers/noise/frame_points.h), with confidence_power as the prior. Process
  // noise: its power over time and by class of joint, which replaces the table
  // process_noise.
  NoiseFrom pixel_noise_from = NoiseFrom::kRecording;
  NoiseFrom process_noise_from = NoiseFrom::kRecording;

  // The detector's bias as a function of the viewing direction, over all people
  // of the recording (solvers/noise/bias_model.h).
  ViewBiasUse view_bias = ViewBiasUse::kOff;

  bool LearnsNoise() const {
    return pixel_noise_from == NoiseFrom::kRecording ||
           process_noise_from == NoiseFrom::kRecording;
  }
  bool EstimatesNoiseScale() const {
    return pixel_noise_from == NoiseFrom::kFixed && estimate_noise_scale;
  }

  bool bones = false;
  double bone_sigma_m = 0.02;
  // kRecording: length and variability of each bone are learnt
  // (solvers/noise/bone_spreads.h). kFixed: the median estimated length, and
  // bone_sigma_m.
  NoiseFrom bone_sigma_from = NoiseFrom::kRecording;

  // A joint without a supporting view is written at most this far from a frame
  // with one [s].
  double bridging_limit_s = 0.5;
  bool covariance = true;

  GraphSolver solver = GraphSolver::kCeres;
  GraphStart start = GraphStart::kBasin;
  int64_t max_iterations = 300;    // of the last stage; earlier stages: 3
  double step_tolerance_m = 3e-5;  // converged when no joint moves farther
  // The batch solves a long recording in chunks of one to two times this
  // length, overlapping their neighbours on both sides by 1.1 s, or more where
  // a joint is rarely measured (MakeChunks); 0 for the recording as a whole
  // [s].
  double chunk_s = 10.0;

  // The following are not configuration keys; they are set in code only.
  //
  // Least weight of an inlier view: three sigmas under Geman-McClure
  // with loss_scale 3.
  double inlier_weight = 0.25;
  // Lower bound of confidences.
  double min_confidence = 0.05;
  // Multiples of loss_scale through which a non-convex loss narrows after the
  // Huber stage.
  std::vector<double> stages = {2.0, 1.0};
  // Prior of a new person's joints: distance from the person's centre, speed.
  double birth_position_sigma_m = 1.0;
  double birth_velocity_sigma_mps = 3.0;
  // Lower bound of the detector error.
  double min_sigma_px = 1.0;
  // Replaces the learnt bias unless view_bias is off.
  std::shared_ptr<const ViewBias> given_view_bias;
  // Additional factors of the caller; need solver ceres.
  UserFactorSource user_factors;
  // Receives the counts of the estimators' solves.
  std::shared_ptr<SolveLedger> ledger;

  void Describe(OptionVisitor& visitor);
};

// CheckOptions, and checks that the options are consistent. Throws OptionError.
void CheckGraphOptions(const GraphOptions& options);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_GRAPH_OPTIONS_H_
