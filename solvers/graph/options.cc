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
                 "scale of the robust loss, as a residual");
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
                 "correlation time of detector errors; 0: white noise");
  visitor.Number("information_scale", &options->information_scale, Positive(),
                 "", "factor on the information of every observation");
  visitor.Boolean("estimate_noise_scale", &options->estimate_noise_scale,
                  "estimate one factor on all sigmas of a person");
  visitor.Choice(
      "pixel_noise_from", &options->pixel_noise_from, {"take", "fixed"},
      "learn detector errors (size, correlation time, dependence on "
      "confidence) from the recording, or use sigma_px, correlation_time_s, "
      "confidence_power");
  visitor.Choice("process_noise_from", &options->process_noise_from,
                 {"take", "fixed"},
                 "learn the process noise, which varies over time, from the "
                 "recording, or use process_noise");
  visitor.Choice("view_bias", &options->view_bias, {"off", "on", "auto"},
                 "learn from the recording how the detector's bias depends on "
                 "the view, and subtract it; auto: only for joints whose "
                 "held-out residuals shrink");
}

void DescribeBones(GraphOptions* options, OptionVisitor& visitor) {
  visitor.Boolean("bones", &options->bones, "use bone-length factors");
  visitor.Number("bone_sigma_m", &options->bone_sigma_m, Positive(), "m",
                 "standard deviation of a bone's length, with bone_sigma_from "
                 "fixed");
  visitor.Choice(
      "bone_sigma_from", &options->bone_sigma_from, {"take", "fixed"},
      "variability of bone lengths: learnt from the recording for each bone, "
      "or bone_sigma_m for all");
}

void DescribeSolver(GraphOptions* options, OptionVisitor& visitor) {
  visitor.Choice("solver", &options->solver, {"ceres", "sweeps"},
                 "Ceres on all factors of a person, or the block-tridiagonal "
                 "solver alone");
  visitor.Choice("start", &options->start, {"basin", "dlt"},
                 "where Ceres starts: at the solution of the block-tridiagonal "
                 "solver, or at DLT");
  visitor.Integer("max_iterations", &options->max_iterations,
                  Between(1.0, 1000.0), "",
                  "maximum iterations of a solve's last stage");
  visitor.Number("step_tolerance_m", &options->step_tolerance_m, Positive(),
                 "m", "converged when a step moves no joint farther than this");
  visitor.Number("chunk_s", &options->chunk_s, NonNegative(), "s",
                 "approximate length of the chunks in which the batch is "
                 "solved; 0: a single chunk");
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
                 "longest time for which a joint is written without a "
                 "supporting view");
  visitor.Boolean(
      "covariance", &covariance,
      "write a covariance of every joint and frame; identities use it");
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
    throw OptionError(
        "graph.stages",
        "expected one or more positive multiples of graph.loss_scale");
  }
  constexpr double kLeastTukey = 0.1;
  if (options.loss == LossKind::kTukey && options.loss_scale < kLeastTukey) {
    throw OptionError("graph.loss_scale",
                      "found less than 0.1 with graph.loss tukey, which would "
                      "reject every observation");
  }
  if (options.start == GraphStart::kDlt &&
      options.solver != GraphSolver::kCeres) {
    throw OptionError("graph.start",
                      "found dlt with graph.solver sweeps, expected basin");
  }
  if (options.user_factors && options.solver != GraphSolver::kCeres) {
    throw OptionError("graph.solver",
                      "found sweeps, expected ceres, which user factors "
                      "require");
  }
}

}  // namespace kinegraph
