// Options of the factor-graph estimators, table [graph]. Free of any solver.
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

// A number for each class of joints, in the order of JointClass.
using JointClassTable = std::array<double, kJointClassCount>;

// The key `name`: one number, or a table by class of joint.
void DescribeJointClasses(OptionVisitor& visitor, const std::string& name,
                          JointClassTable* table, const std::string& unit,
                          const std::string& help);

// Who has the last word on the minimum. Both minimise the same factors.
enum class GraphSolver {
  kCeres,             // one Ceres problem a person with all factors
  kBlockTridiagonal,  // block-tridiagonal elimination; bones by conjugate
                      // gradients on top
};
// Names in the order of the enum.
const char* ToString(GraphSolver solver);

// What Ceres starts from.
enum class GraphStart {
  kBasin,  // graduated non-convexity by block-tridiagonal elimination
  kDlt,    // DLT and the joints filter: all stages are Ceres' own
};

// Where a noise figure comes from.
enum class NoiseFrom {
  kRecording,  // learnt from the recording itself
  kFixed,      // the options' own figures
};

// Whether the detector's bias by view is learnt and taken away.
enum class ViewBiasUse {
  kOff,
  kOn,    // wherever the recording can tell it at all
  kAuto,  // of the joints where the recording's other half gains
};

struct GraphOptions {
  // The window keeps states this long before they become final [s]; 0.4 s are
  // 10 frames at 25 Hz.
  double lag_s = 0.4;

  LossKind loss = LossKind::kGemanMcClure;
  double loss_scale = 3.0;  // sigmas

  // Power of the white noise on acceleration [m^2/s^3].
  //   head trunk shoulder elbow wrist hip knee ankle foot other
  JointClassTable process_noise = {2.0, 1.0, 1.4,  4.0,  6.0,
                                   1.0, 2.0, 10.0, 10.0, 6.0};
  // Detector error of a confidence of 1 [px] at a depth of 4 m with a focal
  // length of 1000 px. It scales with the size of the person in the image.
  JointClassTable sigma_px = {6.0, 6.0, 6.0, 6.0, 6.0, 6.0, 6.0, 6.0, 6.0, 6.0};
  double confidence_power = 0.5;  // sigma grows with confidence^-power

  // Detector errors last: e-folding time [s], 0 for white noise. The
  // information of each observation is scaled, after the loss, by
  // information_scale (1 - rho) / (1 + rho), rho = exp(-dt / tau).
  double correlation_time_s = 0.1;
  double information_scale = 1.5;
  // One factor on all sigmas of a person, from the residuals: of the whole
  // recording (batch), or of what became final so far (window).
  bool estimate_noise_scale = true;

  // Learnt from the recording (solvers/noise), of each person. The pixel noise:
  // how far off the detector is by class of joint and how long its errors last,
  // around sigma_px, instead of the three fields above, and what confidences
  // are worth (solvers/noise/frame_points.h), around confidence_power. The
  // process noise: from moment to moment by class of joint, instead of the
  // table.
  NoiseFrom pixel_noise_from = NoiseFrom::kRecording;
  NoiseFrom process_noise_from = NoiseFrom::kRecording;

  // The detector's bias as a function of the view, over all people of the
  // recording (solvers/noise/bias_model.h).
  ViewBiasUse view_bias = ViewBiasUse::kOff;

  bool LearnsNoise() const {
    return pixel_noise_from == NoiseFrom::kRecording ||
           process_noise_from == NoiseFrom::kRecording;
  }

  bool bones = false;
  double bone_sigma_m = 0.02;
  // Length and freedom of each bone as the recording shows them
  // (solvers/noise/bone_spreads.h); or the median of the estimates and
  // bone_sigma_m.
  NoiseFrom bone_sigma_from = NoiseFrom::kRecording;

  // A joint is written for at most this long without a supporting view [s].
  double bridging_limit_s = 0.5;
  bool covariance = true;

  GraphSolver solver = GraphSolver::kCeres;
  GraphStart start = GraphStart::kBasin;
  int64_t max_iterations = 300;    // of the last stage; earlier ones take three
  double step_tolerance_m = 3e-5;  // converged when no joint moves farther
  // The batch solves a long recording in chunks of about this long, with a
  // second of their neighbours on both sides; 0 for the recording as a whole
  // [s].
  double chunk_s = 10.0;

  // Given in code alone: weight above which a view counts as an inlier (three
  // sigmas under Geman-McClure with loss_scale 3), what lower confidences count
  // as, multiples of loss_scale that a loss that is not convex
  // runs through after a Huber stage, how far a new person's joints may be from
  // its centre and how fast they move, the error that no detector falls below
  // [px], a bias that is known and not learnt (unless view_bias is off),
  // factors of the caller's own (solver ceres), and where estimators add how
  // their solves ended.
  double inlier_weight = 0.25;
  double min_confidence = 0.05;
  std::vector<double> stages = {2.0, 1.0};
  double birth_position_sigma_m = 1.0;
  double birth_velocity_sigma_mps = 3.0;
  double min_sigma_px = 1.0;
  std::shared_ptr<const ViewBias> given_view_bias;
  UserFactorSource user_factors;
  std::shared_ptr<SolveLedger> ledger;

  void Describe(OptionVisitor& visitor);
};

// CheckOptions, and that the parts go together. Throws OptionError.
void CheckGraphOptions(const GraphOptions& options);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_GRAPH_OPTIONS_H_
