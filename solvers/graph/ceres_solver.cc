#include "solvers/graph/ceres_solver.h"

#include <ceres/problem.h>
#include <ceres/solver.h>

#include <optional>

#include "solvers/factors/bone_length_factor.h"
#include "solvers/factors/ceres_loss.h"
#include "solvers/factors/constant_velocity_factor.h"
#include "solvers/factors/marginal_prior_factor.h"
#include "solvers/factors/reprojection_factor.h"
#include "solvers/graph/linear_chain.h"
#include "solvers/graph/person_system.h"

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

  void AddJoint(JointChain* chain) {
    if (person_->prior.empty()) {
      const StatePrior& prior = chain->prior;
      problem_.AddResidualBlock(
          MarginalPriorFactor::Create(prior.A, prior.x0, prior.b), nullptr,
          chain->states[0].data());
    }
    for (size_t k = 0; k < chain->states.size(); ++k) {
      AddFrame(chain, k);
    }
  }

  void AddBones() {
    for (const BoneConstraint& bone : person_->bones) {
      for (size_t k = 0; k < person_->times.size(); ++k) {
        problem_.AddResidualBlock(
            BoneLengthFactor::Create(bone.length_m, bone.sigma_m), nullptr,
            person_->joints[bone.a].states[k].data(),
            person_->joints[bone.b].states[k].data());
      }
    }
  }

  void AddPersonPrior() {
    const PersonPrior& prior = person_->prior;
    if (prior.empty()) return;
    std::vector<double*> blocks;
    for (JointChain& chain : person_->joints) {
      blocks.push_back(chain.states[0].data());
    }
    problem_.AddResidualBlock(
        MarginalPriorFactor::Create(prior.A, prior.x0, prior.b), nullptr,
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
  void AddFrame(JointChain* chain, size_t k) {
    if (k + 1 < chain->states.size()) {
      const double dt_s = ToSeconds(person_->times[k + 1] - person_->times[k]);
      problem_.AddResidualBlock(
          ConstantVelocityFactor::Create(dt_s, chain->process_noise), nullptr,
          chain->states[k].data(), chain->states[k + 1].data());
    }
    for (int32_t m = chain->first[k]; m < chain->first[k + 1]; ++m) {
      const PixelMeasurement& measurement = chain->measurements[m];
      if (measurement.gated) continue;
      problem_.AddResidualBlock(
          ReprojectionFactor::Create(measurement.camera, measurement.px,
                                     measurement.sigma_px,
                                     measurement.offset_s),
          MakeCeresLoss(stage_.loss, stage_.scale, measurement.information),
          chain->states[k].data());
    }
  }

  PersonProblem* person_;
  SolveStage stage_;
  ceres::Problem problem_;
};

void StoreWeights(const SolveStage& stage, JointChain* chain) {
  for (size_t k = 0; k < chain->states.size(); ++k) {
    const State& state = chain->states[k];
    for (int32_t m = chain->first[k]; m < chain->first[k + 1]; ++m) {
      PixelMeasurement& measurement = chain->measurements[m];
      measurement.weight = 0.0;
      if (measurement.gated) continue;
      const std::optional<Eigen::Vector2d> image = measurement.camera->Project(
          state.head<3>() + measurement.offset_s * state.tail<3>());
      if (!image.has_value()) continue;
      const double s = (*image - measurement.px).squaredNorm() /
                       (measurement.sigma_px * measurement.sigma_px);
      measurement.weight = EvaluateLoss(stage.loss, stage.scale, s).first;
    }
  }
}

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
  for (JointChain& chain : problem->joints) builder.AddJoint(&chain);
  builder.AddBones();
  builder.AddPersonPrior();
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
    std::vector<double> weights;
    for (const PixelMeasurement& measurement : chain.measurements) {
      weights.push_back(measurement.weight);
    }
    report.unsettled += DoubtUnsettled(last_step[j], chain, &weights);
    for (size_t m = 0; m < weights.size(); ++m) {
      chain.measurements[m].weight = weights[m];
    }
  }
  return report;
}

}  // namespace kinegraph
