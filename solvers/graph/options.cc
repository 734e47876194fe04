#include "solvers/graph/options.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "solvers/factors/loss.h"

namespace kinegraph {

void DescribeJointClasses(OptionVisitor& visitor, const std::string& name,
                          JointClassTable* table, const std::string& unit,
                          const std::string& help) {
  std::vector<std::string> names;
  for (int i = 0; i < kJointClassCount; ++i) {
    names.emplace_back(ToString(static_cast<JointClass>(i)));
  }
  visitor.NumberTable(name, table->data(), names, Positive(), unit, help);
}

namespace {

// The keys in groups, in the order in which a configuration lists them.
void DescribeLoss(GraphOptions* options, OptionVisitor& visitor) {
  visitor.Choice("loss", &options->loss, LossNames(),
                 "robust loss of the reprojections");
  visitor.Number("loss_scale", &options->loss_scale, Positive(), "sigmas",
                 "where the loss starts to doubt an observation");
}

void DescribeNoise(GraphOptions* options, OptionVisitor& visitor) {
  DescribeJointClasses(visitor, "process_noise", &options->process_noise,
                       "m^2/s^3", "power of the white noise on acceleration");
  DescribeJointClasses(
      visitor, "sigma_px", &options->sigma_px, "px",
      "detector error at 4 m, focal length 1000 px, confidence 1");
  visitor.Number("confidence_power", &options->confidence_power,
                 Between(0.0, 4.0), "",
                 "the detector error grows with confidence^-power");
  visitor.Number("correlation_time_s", &options->correlation_time_s,
                 Between(0.0, 60.0), "s",
                 "how long detector errors last; 0: white noise");
  visitor.Number("information_scale", &options->information_scale, Positive(),
                 "", "factor on the information of every observation");
  visitor.Boolean("estimate_noise_scale", &options->estimate_noise_scale,
                  "estimate one factor on all sigmas of a person");
  visitor.Choice("pixel_noise_from", &options->pixel_noise_from,
                 {"take", "fixed"},
                 "learn the detector's error, how long it lasts and what "
                 "confidences are worth from the recording, or use the figures "
                 "here");
  visitor.Choice("process_noise_from", &options->process_noise_from,
                 {"take", "fixed"},
                 "learn the process noise from moment to moment from the "
                 "recording, or use the table");
  visitor.Choice("view_bias", &options->view_bias, {"off", "on", "auto"},
                 "learn from the recording how the detector's error depends on "
                 "the view, and remove it; auto: of the joints that gain on "
                 "the other half of the recording");
}

void DescribeBones(GraphOptions* options, OptionVisitor& visitor) {
  visitor.Boolean("bones", &options->bones, "use bone-length factors");
  visitor.Number("bone_sigma_m", &options->bone_sigma_m, Positive(), "m",
                 "how far a bone's length may vary, if fixed");
  visitor.Choice(
      "bone_sigma_from", &options->bone_sigma_from, {"take", "fixed"},
      "how far a bone's length may vary: as the recording shows of each "
      "bone, or bone_sigma_m for all");
}

void DescribeSolver(GraphOptions* options, OptionVisitor& visitor) {
  visitor.Choice("solver", &options->solver, {"ceres", "sweeps"},
                 "Ceres on all factors of a person, or the block-tridiagonal "
                 "solver alone");
  visitor.Choice("start", &options->start, {"basin", "dlt"},
                 "where Ceres starts: the basin that the block-tridiagonal "
                 "solver finds, or DLT");
  visitor.Integer("max_iterations", &options->max_iterations,
                  Between(1.0, 1000.0), "", "iterations of the last stage");
  visitor.Number("step_tolerance_m", &options->step_tolerance_m, Positive(),
                 "m", "converged when no joint moves farther");
  visitor.Number("chunk_s", &options->chunk_s, NonNegative(), "s",
                 "the batch is solved in chunks of about this; 0: as a whole");
}

}  // namespace

void GraphOptions::Describe(OptionVisitor& visitor) {
  visitor.Enter("graph");
  visitor.Number("lag_s", &lag_s, Between(0.0, 60.0), "s",
                 "how long the window keeps a frame before it is final");
  DescribeLoss(this, visitor);
  DescribeNoise(this, visitor);
  DescribeBones(this, visitor);
  visitor.Number("bridging_limit_s", &bridging_limit_s, NonNegative(), "s",
                 "how long a joint is written without a supporting view");
  visitor.Boolean("covariance", &covariance,
                  "compute a covariance of every joint and frame");
  DescribeSolver(this, visitor);
  visitor.Leave();
}

const char* ToString(GraphSolver solver) {
  return solver == GraphSolver::kCeres ? "ceres" : "sweeps";
}

void CheckGraphOptions(const GraphOptions& options) {
  CheckOptions(options);
  const auto is_positive = [](double multiple) {
    return std::isfinite(multiple) && multiple > 0.0;
  };
  if (options.stages.empty() ||
      !std::all_of(options.stages.begin(), options.stages.end(), is_positive)) {
    throw OptionError("graph.stages",
                      "expected positive multiples, one or more");
  }
  if (options.start == GraphStart::kDlt &&
      options.solver != GraphSolver::kCeres) {
    throw OptionError("graph.start",
                      "found dlt with graph.solver sweeps, expected basin");
  }
  if (options.user_factors && options.solver != GraphSolver::kCeres) {
    throw OptionError("graph.solver",
                      "found sweeps with factors of the user's own, expected "
                      "ceres");
  }
}

}  // namespace kinegraph
