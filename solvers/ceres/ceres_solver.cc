#include "solvers/ceres/ceres_solver.h"

#include <ceres/problem.h>
#include <ceres/solver.h>
#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/base/stop_check.h"
#include "solvers/ceres/ceres_factor.h"
#include "solvers/ceres/ceres_loss.h"
#include "solvers/ceres/view_bundle.h"
#include "solvers/graph/creep.h"
#include "solvers/graph/factor_list.h"

namespace kinegraph {
namespace {

// Watches how far the positions move, and ends the solve when none does.
class MoveWatch final : public ceres::IterationCallback {
 public:
  // `person` and `step` outlive the watch; `step` receives the last accepted
  // step of all states.
  MoveWatch(const PersonProblem* person, double tolerance_m, PersonStates* step)
      : person_(person),
        tolerance_m_(tolerance_m),
        step_(step),
        before_(StatesOf(*person)) {}

  bool settled() const { return settled_; }
  // How many more steps like the last are to come (creep.h); 0: not known.
  double to_come() const {
    return steps_ < 2 ? 0.0 : StepsToCome(previous_step_, *step_);
  }
  // To be called before every solve.
  void Restart() {
    before_ = StatesOf(*person_);
    steps_ = 0;
  }

  ceres::CallbackReturnType operator()(
      const ceres::IterationSummary& summary) override {
    if (summary.iteration == 0 || !summary.step_is_successful) {
      return ceres::SOLVER_CONTINUE;
    }
    double farthest_m = 0.0;
    previous_step_ = *step_;
    ++steps_;
    for (size_t j = 0; j < before_.size(); ++j) {
      const StateChain& now = person_->joints[j].states;
      for (size_t k = 0; k < now.size(); ++k) {
        (*step_)[j][k] = now[k] - before_[j][k];
        before_[j][k] = now[k];
        farthest_m = std::max(farthest_m,
                              (*step_)[j][k].head<3>().cwiseAbs().maxCoeff());
      }
    }
    // A trust region that holds the step back proves nothing: its damping is
    // the diagonal over the radius.
    constexpr double kFree = 1e3;
    if (!(farthest_m < tolerance_m_) || summary.trust_region_radius < kFree) {
      return ceres::SOLVER_CONTINUE;
    }
    settled_ = true;
    return ceres::SOLVER_TERMINATE_SUCCESSFULLY;
  }

 private:
  const PersonProblem* person_;
  const double tolerance_m_;
  PersonStates* step_;
  PersonStates before_;
  PersonStates previous_step_;
  int steps_ = 0;  // of this solve
  bool settled_ = false;
};

// A user's factor, which the problem keeps.
class CeresGeneral final : public ceres::CostFunction {
 public:
  explicit CeresGeneral(const GeneralFactor* factor) : factor_(factor) {
    set_num_residuals(factor->residual_count());
    mutable_parameter_block_sizes()->assign(factor->state_count(), kStateSize);
  }
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    return factor_->Evaluate(parameters, residuals, jacobians);
  }

 private:
  const GeneralFactor* factor_;
};

// Builds a person's Ceres problem for one stage. The states are Ceres'
// parameter blocks: they must not move while it lives.
class PersonBuilder {
 public:
  PersonBuilder(PersonProblem* person, const SolveStage& stage)
      : person_(person), ceres_(MakeOptions()) {
    FactorWalk walk;
    walk.stage = stage;
    const auto add = [this](const auto& factor, const auto& keys,
                            const Robustness& robustness) {
      Add(factor, keys, robustness);
      return true;
    };
    ForEachFactor(*person, walk, add);
    CloseBundle();
    AddPrior();
    for (const PlacedFactor& placed : person->user) AddGeneral(placed);
  }

  ceres::Problem* problem() { return &ceres_; }

 private:
  static ceres::Problem::Options MakeOptions() {
    ceres::Problem::Options options;
    options.disable_all_safety_checks = true;  // our own blocks, no repeats
    return options;
  }

  double* Block(const StateKey& key) {
    return person_->joints[key.joint].states[key.frame].data();
  }

  template <typename Factor, size_t kCount>
  void Add(const Factor& factor, const std::array<StateKey, kCount>& keys,
           const Robustness& robustness) {
    if constexpr (std::is_same_v<Factor, CameraReprojection>) {
      double* const block = Block(keys[0]);
      if (block != bundle_block_) CloseBundle();
      bundle_block_ = block;
      bundle_.push_back({factor, robustness});
    } else {
      std::vector<double*> blocks;
      for (const StateKey& key : keys) blocks.push_back(Block(key));
      ceres_.AddResidualBlock(MakeCeresFactor(factor),
                              MakeCeresLoss(robustness.loss, robustness.scale,
                                            robustness.information),
                              blocks);
    }
  }

  void CloseBundle() {
    if (bundle_.empty()) return;
    ceres_.AddResidualBlock(new ViewBundle(std::move(bundle_)), nullptr,
                            bundle_block_);
    bundle_.clear();
  }

  void AddPrior() {
    if (person_->prior.empty()) return;
    std::vector<double*> blocks;
    for (JointChain& chain : person_->joints) {
      blocks.push_back(chain.states[0].data());
    }
    ceres_.AddResidualBlock(new CeresPersonPrior(&person_->prior), nullptr,
                            blocks);
  }

  void AddGeneral(const PlacedFactor& placed) {
    std::vector<double*> blocks;
    for (const StateKey& key : placed.keys) blocks.push_back(Block(key));
    ceres_.AddResidualBlock(
        new CeresGeneral(placed.factor.get()),
        MakeCeresLoss(placed.robustness.loss, placed.robustness.scale, 1.0),
        blocks);
  }

  PersonProblem* person_;
  ceres::Problem ceres_;
  std::vector<ViewBundle::View> bundle_;  // of one joint in one frame
  double* bundle_block_ = nullptr;
};

ceres::Solver::Options OptionsFor(const SolveStage& stage,
                                  double step_tolerance_m, int blocks) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  // In windows Eigen's sparse Cholesky beats SuiteSparse's (28 against 44 ms
  // with bones). In takes bones fill the factor: Campus by the batch took 41 s
  // with the one and 29 with the other.
  constexpr int kManyBlocks = 400;
  options.sparse_linear_algebra_library_type =
      blocks > kManyBlocks ? ceres::SUITE_SPARSE : ceres::EIGEN_SPARSE;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  options.max_num_iterations = stage.max_iterations;
  // MoveWatch ends a solve; these only where rounding hides what is left. The
  // cost changes with the square of a step, positions are metres.
  options.parameter_tolerance = 1e-4 * step_tolerance_m;
  options.function_tolerance = 1e-3 * step_tolerance_m * step_tolerance_m;
  options.gradient_tolerance = 1e-12;
  options.initial_trust_region_radius = 1e12;  // nearly Gauss-Newton
  options.max_trust_region_radius = 1e16;
  options.update_state_every_iteration = true;  // for MoveWatch
  return options;
}

double CostOf(ceres::Problem* problem) {
  double cost = std::numeric_limits<double>::infinity();
  if (!problem->Evaluate(ceres::Problem::EvaluateOptions(), &cost, nullptr,
                         nullptr, nullptr)) {
    return std::numeric_limits<double>::infinity();
  }
  return cost;
}

// Goes on along a step that creeps, if the cost falls (creep.h).
void LeapAhead(double to_come, double cost, const PersonStates& step,
               ceres::Problem* problem, PersonProblem* person) {
  const PersonStates here = StatesOf(*person);
  for (size_t j = 0; j < step.size(); ++j) {
    for (size_t k = 0; k < step[j].size(); ++k) {
      person->joints[j].states[k] += to_come * step[j][k];
    }
  }
  if (CostOf(problem) < cost) return;
  for (size_t j = 0; j < here.size(); ++j) {
    std::copy(here[j].begin(), here[j].end(), person->joints[j].states.begin());
  }
}

void Add(const ceres::Solver::Summary& summary, SolveReport* report) {
  report->finite = report->finite && summary.IsSolutionUsable();
  report->ceres_iterations += static_cast<int>(summary.iterations.size()) - 1;
  report->cholmod_problems =
      summary.sparse_linear_algebra_library_type == ceres::SUITE_SPARSE ? 1 : 0;
}

// Nearly free steps have not lowered the cost. At the minimum much shorter
// ones, from `radius` on, do not either, but for rounding. Elsewhere the valley
// winds: what the sweeps found stays, and has not converged.
bool IsAtRounding(ceres::Solver::Options options, double radius,
                  ceres::Problem* problem, PersonProblem* person) {
  // Of the cost. The sum of a person's thousands of terms is good to 1e-13, and
  // under a curvature of 1e4 / m^2 this share of a cost of 1e3 is 1e-5 m.
  constexpr double kRounding = 1e-9;
  const PersonStates here = StatesOf(*person);
  options.initial_trust_region_radius = radius;
  options.callbacks.clear();
  ceres::Solver::Summary summary;
  ceres::Solve(options, problem, &summary);
  for (size_t j = 0; j < here.size(); ++j) {
    std::copy(here[j].begin(), here[j].end(), person->joints[j].states.begin());
  }
  return summary.IsSolutionUsable() &&
         summary.initial_cost - summary.final_cost <=
             kRounding * summary.initial_cost;
}

// A few iterations at a time, with a leap between them where they creep.
SolveReport RunStage(const SolveStage& stage, double step_tolerance_m,
                     PersonProblem* person, PersonStates* last_step) {
  constexpr int kBurst = 5;
  PersonBuilder builder(person, stage);
  MoveWatch watch(person, step_tolerance_m, last_step);
  ceres::Solver::Options options = OptionsFor(
      stage, step_tolerance_m, builder.problem()->NumParameterBlocks());
  options.callbacks.push_back(&watch);
  SolveReport report;
  report.ceres_problems = 1;
  report.converged = false;
  double initial_cost = 0.0;
  while (report.finite && !report.converged) {
    const int left = stage.max_iterations - report.ceres_iterations;
    if (left <= 0) break;
    CheckStop();  // never inside of Ceres, which is no place to throw
    options.max_num_iterations = std::min(kBurst, left);
    ceres::Solver::Summary summary;
    watch.Restart();
    ceres::Solve(options, builder.problem(), &summary);
    VLOG(2) << summary.FullReport();
    if (report.ceres_iterations == 0) initial_cost = summary.initial_cost;
    Add(summary, &report);
    report.cost_decrease = initial_cost - summary.final_cost;
    report.converged =
        watch.settled() || summary.termination_type == ceres::CONVERGENCE;
    // Of the steps that Ceres counts the first is the start.
    if (!report.converged && summary.num_successful_steps == 1) {
      report.converged =
          IsAtRounding(options, summary.iterations.back().trust_region_radius,
                       builder.problem(), person);
      break;
    }
    if (!report.converged && watch.to_come() > 0.0) {
      LeapAhead(watch.to_come(), summary.final_cost, *last_step,
                builder.problem(), person);
    }
  }
  return report;
}

void Merge(const SolveReport& stage, SolveReport* whole) {
  whole->finite = whole->finite && stage.finite;
  whole->converged = stage.converged;
  whole->ceres_iterations += stage.ceres_iterations;
  whole->ceres_problems += stage.ceres_problems;
  whole->cholmod_problems += stage.cholmod_problems;
  whole->cost_decrease = stage.cost_decrease;
}

}  // namespace

SolveReport SolveWithCeres(const SolveSchedule& schedule,
                           PersonProblem* problem) {
  SolveReport report;
  if (problem->times.empty() || schedule.stages.empty()) return report;
  PersonStates last_step = StatesOf(*problem);
  for (StateChain& step : last_step) {
    std::fill(step.begin(), step.end(), State::Zero());
  }
  for (const SolveStage& stage : schedule.stages) {
    Merge(RunStage(stage, schedule.step_tolerance_m, problem, &last_step),
          &report);
  }
  for (size_t j = 0; j < problem->joints.size(); ++j) {
    JointChain& chain = problem->joints[j];
    StoreWeights(schedule.stages.back(), &chain);
    if (report.converged || !schedule.doubt_unsettled) continue;
    report.unsettled += DoubtUnsettled(last_step[j], &chain);
  }
  return report;
}

}  // namespace kinegraph
