#include "solvers/ceres/ceres_solver.h"

#include <ceres/problem.h>
#include <ceres/solver.h>

#include <vector>

#include "solvers/ceres/ceres_factor.h"
#include "solvers/ceres/ceres_loss.h"
#include "solvers/graph/factor_list.h"

namespace kinegraph {
namespace {

// Keeps the last accepted step of every joint of a person.
class StepRecorder final : public ceres::IterationCallback {
 public:
  StepRecorder(const PersonProblem* person, PersonStates* step)
      : person_(person), step_(step) {}

  ceres::CallbackReturnType operator()(
      const ceres::IterationSummary& summary) override {
    before_.resize(person_->joints.size());
    for (size_t j = 0; j < person_->joints.size(); ++j) {
      const std::vector<State>& now = person_->joints[j].states;
      if (summary.iteration > 0 && summary.step_is_successful &&
          now != before_[j]) {
        (*step_)[j].resize(now.size());
        for (size_t k = 0; k < now.size(); ++k) {
          (*step_)[j][k] = now[k] - before_[j][k];
        }
      }
      before_[j] = now;
    }
    return ceres::SOLVER_CONTINUE;
  }

 private:
  const PersonProblem* person_;
  PersonStates* step_;
  PersonStates before_;
};

// Builds one Ceres problem over all or one of a person's joints. The states
// are Ceres' parameter blocks: they must not move while it lives.
class CeresBuilder {
 public:
  CeresBuilder(PersonProblem* person, const SolveStage& stage)
      : person_(person), stage_(stage) {
    ceres::Problem::Options options;
    options.disable_all_safety_checks = true;  // our own blocks, no repeats
    problem_ = ceres::Problem(options);
  }

  // One joint alone.
  void AddJoint(JointChain* chain) {
    ForEachFactor(
        person_->times, *chain, 0, Walk(),
        [&](const auto& factor, const auto& keys,
            const Robustness& robustness) {
          Add(
              factor, robustness,
              [&](size_t i) { return chain->states[keys[i].frame].data(); },
              keys.size());
          return true;
        });
  }

  // All joints and what couples them.
  void AddPerson() {
    ForEachFactor(*person_, Walk(),
                  [&](const auto& factor, const auto& keys,
                      const Robustness& robustness) {
                    Add(
                        factor, robustness,
                        [&](size_t i) {
                          return person_->joints[keys[i].joint]
                              .states[keys[i].frame]
                              .data();
                        },
                        keys.size());
                    return true;
                  });
    if (person_->prior.empty()) return;
    std::vector<double*> blocks;
    for (JointChain& chain : person_->joints) {
      blocks.push_back(chain.states[0].data());
    }
    problem_.AddResidualBlock(new CeresPersonPrior(&person_->prior), nullptr,
                              blocks);
  }

  // `last_step` receives, by joint of the person, the last step of its states.
  SolveReport Solve(double step_tolerance_m, PersonStates* last_step) {
    StepRecorder recorder(person_, last_step);
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    // In windows Eigen's sparse Cholesky beats SuiteSparse's (28 against 44 ms
    // with bones); whole takes with bones are left to SuiteSparse's orderings.
    constexpr int kManyBlocks = 2000;
    options.sparse_linear_algebra_library_type =
        problem_.NumParameterBlocks() > kManyBlocks ? ceres::SUITE_SPARSE
                                                    : ceres::EIGEN_SPARSE;
    options.num_threads = 1;
    options.logging_type = ceres::SILENT;
    options.max_num_iterations = stage_.max_iterations;
    // Ceres' tolerances are relative. Positions are metres, so a hundredth of
    // our step is safe; the cost changes with the square of a step.
    options.parameter_tolerance = 1e-2 * step_tolerance_m;
    options.function_tolerance = step_tolerance_m * step_tolerance_m;
    options.gradient_tolerance = 1e-12;
    options.initial_trust_region_radius = 1e12;  // nearly Gauss-Newton
    options.max_trust_region_radius = 1e16;
    options.update_state_every_iteration = true;
    options.callbacks.push_back(&recorder);
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    SolveReport report;
    report.finite = summary.IsSolutionUsable();
    report.converged = summary.termination_type == ceres::CONVERGENCE;
    report.iterations = static_cast<int>(summary.iterations.size());
    return report;
  }

 private:
  FactorWalk Walk() const {
    FactorWalk walk;
    walk.stage = stage_;
    return walk;
  }

  template <typename Factor, typename BlockOf>
  void Add(const Factor& factor, const Robustness& robustness,
           const BlockOf& block_of, size_t key_count) {
    std::vector<double*> blocks;
    for (size_t i = 0; i < key_count; ++i) blocks.push_back(block_of(i));
    problem_.AddResidualBlock(MakeCeresFactor(factor),
                              MakeCeresLoss(robustness.loss, robustness.scale,
                                            robustness.information),
                              blocks);
  }

  PersonProblem* person_;
  SolveStage stage_;
  ceres::Problem problem_;
};

void Merge(const SolveReport& part, SolveReport* whole) {
  whole->finite = whole->finite && part.finite;
  whole->converged = whole->converged && part.converged;
  whole->iterations += part.iterations;
}

SolveReport RunStage(const SolveStage& stage, double step_tolerance_m,
                     PersonProblem* problem, PersonStates* last_step) {
  SolveReport report;
  if (problem->bones.empty() && problem->prior.empty()) {
    for (JointChain& chain : problem->joints) {
      CeresBuilder builder(problem, stage);
      builder.AddJoint(&chain);
      Merge(builder.Solve(step_tolerance_m, last_step), &report);
    }
    return report;
  }
  CeresBuilder builder(problem, stage);
  builder.AddPerson();
  Merge(builder.Solve(step_tolerance_m, last_step), &report);
  return report;
}

}  // namespace

SolveReport SolveWithCeres(const SolveSchedule& schedule,
                           PersonProblem* problem) {
  SolveReport report;
  if (problem->times.empty()) return report;
  PersonStates last_step(problem->joints.size());
  for (const SolveStage& stage : schedule.stages) {
    const SolveReport part =
        RunStage(stage, schedule.step_tolerance_m, problem, &last_step);
    report.finite = report.finite && part.finite;
    report.converged = part.converged;
    report.iterations += part.iterations;
  }
  if (schedule.stages.empty()) return report;
  for (size_t j = 0; j < problem->joints.size(); ++j) {
    JointChain& chain = problem->joints[j];
    StoreWeights(schedule.stages.back(), &chain);
    if (report.converged || !schedule.doubt_unsettled) continue;
    report.unsettled += DoubtUnsettled(last_step[j], &chain);
  }
  return report;
}

}  // namespace kinegraph
