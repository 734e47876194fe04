#include "solvers/ceres/ceres_solver.h"

#include <ceres/problem.h>
#include <ceres/solver.h>
#include <glog/logging.h>

#include <algorithm>
#include <exception>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/base/stop_check.h"
#include "solvers/ceres/ceres_factor.h"
#include "solvers/graph/factor_list.h"

namespace kinegraph {
namespace {

// Ends a solve whose step moved no position far, and one that somebody stops.
class StepWatch final : public ceres::IterationCallback {
 public:
  // `person` outlives the watch.
  StepWatch(const PersonProblem* person, double tolerance_m)
      : person_(person),
        tolerance_m_(tolerance_m),
        states_(StatesOf(*person)),
        step_(states_) {}

  // The last accepted step of all states.
  const PersonStates& step() const { return step_; }
  // Throws what ended the solve (stop_check.h): Ceres is no place to throw.
  void RethrowStop() const {
    if (stop_ != nullptr) std::rethrow_exception(stop_);
  }

  ceres::CallbackReturnType operator()(
      const ceres::IterationSummary& summary) override {
    try {
      CheckStop();
    } catch (...) {
      stop_ = std::current_exception();
      return ceres::SOLVER_ABORT;
    }
    if (summary.iteration == 0 || !summary.step_is_successful) {
      return ceres::SOLVER_CONTINUE;
    }
    double farthest_m = 0.0;
    for (size_t j = 0; j < states_.size(); ++j) {
      const StateChain& now = person_->joints[j].states;
      for (size_t k = 0; k < now.size(); ++k) {
        step_[j][k] = now[k] - states_[j][k];
        states_[j][k] = now[k];
        farthest_m =
            std::max(farthest_m, step_[j][k].head<3>().cwiseAbs().maxCoeff());
      }
    }
    // A trust region that holds the step back proves nothing: its damping is
    // the diagonal over the radius.
    constexpr double kFree = 1e3;
    return farthest_m < tolerance_m_ && summary.trust_region_radius >= kFree
               ? ceres::SOLVER_TERMINATE_SUCCESSFULLY
               : ceres::SOLVER_CONTINUE;
  }

 private:
  const PersonProblem* person_;
  const double tolerance_m_;
  PersonStates states_;
  PersonStates step_;
  std::exception_ptr stop_;
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
// parameter blocks, joint by joint: they must not move while it lives.
class PersonBuilder {
 public:
  PersonBuilder(PersonProblem* person, const SolveStage& stage)
      : person_(person), ceres_(MakeOptions()) {
    for (JointChain& chain : person->joints) {
      for (State& state : chain.states) {
        ceres_.AddParameterBlock(state.data(), kStateSize);
      }
    }
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
      ceres_.AddResidualBlock(new CeresFactor<Factor>(factor),
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
                                  double step_tolerance_m) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  // CHOLMOD's supernodes would start OpenMP's threads, whatever num_threads is.
  options.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  options.max_num_iterations = stage.max_iterations;
  // StepWatch ends a solve; these only where rounding hides what is left. The
  // cost changes with the square of a step, positions are metres.
  options.parameter_tolerance = 1e-4 * step_tolerance_m;
  options.function_tolerance = 1e-3 * step_tolerance_m * step_tolerance_m;
  options.gradient_tolerance = 1e-12;
  options.initial_trust_region_radius = 1e12;  // nearly Gauss-Newton
  options.max_trust_region_radius = 1e16;
  options.update_state_every_iteration = true;  // for StepWatch
  return options;
}

// Adds what the stage did to the report.
void RunStage(const SolveStage& stage, const SolveSchedule& schedule,
              PersonProblem* person, SolveReport* report) {
  PersonBuilder builder(person, stage);
  ++report->ceres_problems;
  StepWatch watch(person, schedule.step_tolerance_m);
  ceres::Solver::Options options = OptionsFor(stage, schedule.step_tolerance_m);
  options.callbacks.push_back(&watch);
  ceres::Solver::Summary summary;
  ceres::Solve(options, builder.problem(), &summary);
  watch.RethrowStop();
  VLOG(2) << summary.FullReport();
  report->finite = report->finite && summary.IsSolutionUsable();
  report->converged = summary.termination_type == ceres::CONVERGENCE ||
                      summary.termination_type == ceres::USER_SUCCESS;
  report->ceres_iterations += static_cast<int>(summary.iterations.size()) - 1;
  report->cost_decrease = summary.initial_cost - summary.final_cost;
  const bool doubt = !report->converged && schedule.doubt_unsettled;
  report->unsettled = 0;
  for (size_t j = 0; j < person->joints.size(); ++j) {
    JointChain& chain = person->joints[j];
    StoreWeights(stage, &chain);
    if (doubt) report->unsettled += DoubtUnsettled(watch.step()[j], &chain);
  }
}

}  // namespace

SolveReport SolveWithCeres(const SolveSchedule& schedule,
                           PersonProblem* problem) {
  SolveReport report;
  if (problem->times.empty()) return report;
  for (const SolveStage& stage : schedule.stages) {
    RunStage(stage, schedule, problem, &report);
  }
  return report;
}

}  // namespace kinegraph
