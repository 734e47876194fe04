#include "solvers/graph/options.h"

#include "core/base/error.h"

namespace kinegraph {

void DescribeJointClasses(OptionVisitor& visitor, const std::string& name,
                          JointClassTable* table, const std::string& unit,
                          const std::string& help) {
  visitor.Enter(name);
  for (int i = 0; i < kJointClassCount; ++i) {
    visitor.Number(ToString(static_cast<JointClass>(i)), &(*table)[i],
                   Positive(), unit, help);
  }
  visitor.Leave();
}

void GraphOptions::Describe(OptionVisitor& visitor) {
  visitor.Enter("graph");
  visitor.Number("lag_s", &lag_s, Between(0.0, 60.0), "s",
                 "How long the window keeps a frame before it is final.");
  visitor.Choice("loss", &loss, LossNames(),
                 "Robust loss of the reprojections.");
  visitor.Number("loss_scale", &loss_scale, Positive(), "sigmas",
                 "Where the loss starts to doubt an observation.");
  visitor.NumberList("stages", &stages, Positive(), "",
                     "Multiples of loss_scale that a non-convex loss runs "
                     "through after a Huber stage.");
  visitor.Number("inlier_weight", &inlier_weight, Between(0.0, 1.0), "",
                 "Weight from which a view counts as an inlier.");
  DescribeJointClasses(visitor, "process_noise", &process_noise, "m^2/s^3",
                       "Power of the white noise on acceleration.");
  DescribeJointClasses(
      visitor, "sigma_px", &sigma_px, "px",
      "Detector error at 4 m, focal length 1000 px, confidence 1.");
  visitor.Number("min_sigma_px", &min_sigma_px, Positive(), "px",
                 "Smallest detector error.");
  visitor.Number("confidence_power", &confidence_power, Between(0.0, 4.0), "",
                 "The detector error grows with confidence^-power.");
  visitor.Number("min_confidence", &min_confidence, Limits{0.0, 1.0, true}, "",
                 "Lower confidences count as this.");
  visitor.Number("correlation_time_s", &correlation_time_s, Between(0.0, 60.0),
                 "s", "How long detector errors last; 0: white noise.");
  visitor.Number("information_scale", &information_scale, Positive(), "",
                 "Factor on the information of every observation.");
  visitor.Boolean("estimate_noise_scale", &estimate_noise_scale,
                  "Estimate one factor on all sigmas of a person.");
  visitor.Choice("pixel_noise_from", &pixel_noise_from, {"take", "fixed"},
                 "Learn the detector's error and how long it lasts from the "
                 "take, or use the figures here.");
  visitor.Choice("process_noise_from", &process_noise_from, {"take", "fixed"},
                 "Learn the process noise from moment to moment from the "
                 "take, or use the table.");
  visitor.Choice("view_bias", &view_bias, {"off", "on", "auto"},
                 "Learn from the take how the detector's error depends on the "
                 "view and take it away; auto: of the joints where the other "
                 "half of the take gains.");
  visitor.Boolean("rival_starts", &rival_starts,
                  "Where most views of a joint are lost, also solve from other "
                  "starts and keep what costs least.");
  visitor.Number("birth_position_sigma_m", &birth_position_sigma_m, Positive(),
                 "m", "Spread of the joints around the person's centre.");
  visitor.Number("birth_velocity_sigma_mps", &birth_velocity_sigma_mps,
                 Positive(), "m/s", "Spread of the joints' first velocity.");
  visitor.Boolean("bones", &bones, "Use bone-length factors.");
  visitor.Number("bone_sigma_m", &bone_sigma_m, Positive(), "m",
                 "How far a bone's length may vary, if fixed.");
  visitor.Choice("bone_sigma_from", &bone_sigma_from, {"take", "fixed"},
                 "How far a bone's length may vary: as the take shows of each "
                 "bone, or bone_sigma_m for all.");
  visitor.Choice("bone_loss", &bone_loss, LossNames(),
                 "Robust loss of lengths whose freedom the take shows; it "
                 "begins at three times that.");
  visitor.Boolean("bone_swing", &bone_swing,
                  "Steps know that a stretched bone resists what turns it; off "
                  "for figures of older versions.");
  visitor.Number("bridging_limit_s", &bridging_limit_s, NonNegative(), "s",
                 "How long a joint is written without a supporting view.");
  visitor.Boolean("covariance", &covariance,
                  "Compute a covariance of every joint and frame.");
  visitor.Choice("start_from", &start_from, {"triangulation", "motion"},
                 "Where the window starts a new state: where the frame's own "
                 "views place the joint, or where the motion leads.");
  visitor.Choice("solver", &solver, {"ceres", "sweeps"},
                 "Ceres, started from block-tridiagonal sweeps, or these "
                 "alone.");
  visitor.Integer("max_iterations", &max_iterations, Between(1.0, 1000.0), "",
                  "Iterations of the last stage.");
  visitor.Number("step_tolerance_m", &step_tolerance_m, Positive(), "m",
                 "Converged when no joint moves farther.");
  visitor.Number("chunk_s", &chunk_s, NonNegative(), "s",
                 "The batch is solved in chunks of about this; 0: as a whole.");
  visitor.Leave();
}

const char* ToString(GraphSolver solver) {
  return solver == GraphSolver::kCeres ? "ceres" : "sweeps";
}

void CheckGraphOptions(const GraphOptions& options) {
  CheckOptions(options);
  if (options.user_factors && options.solver != GraphSolver::kCeres) {
    throw OptionError("graph.solver",
                      "found sweeps with factors of the user's own, expected "
                      "ceres");
  }
}

}  // namespace kinegraph
