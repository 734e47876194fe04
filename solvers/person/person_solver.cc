#include "solvers/person/person_solver.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "solvers/block_tridiagonal/person_system.h"
#include "solvers/graph/assembler.h"

namespace kinegraph {
namespace {

SolveSchedule LastStage(SolveSchedule schedule) {
  schedule.stages.erase(schedule.stages.begin(), schedule.stages.end() - 1);
  return schedule;
}

}  // namespace

PersonSolver::PersonSolver(const GraphOptions& options)
    : solver_(options.solver),
      start_(options.start),
      ledger_(options.ledger),
      schedule_(MakeSchedule(options)),
      last_stage_(LastStage(schedule_)),
      correction_(InformationCorrection(
          schedule_.stages.back().loss,
          schedule_.stages.back().scale *
              (options.pixel_noise_from == NoiseFrom::kRecording
                   ? kLearntWidening
                   : 1.0))) {}

void PersonSolver::SolveJoints(const SolveSchedule& schedule,
                               PersonProblem* problem) {
  if (start_ == GraphStart::kDlt) {
    SolveJointsWithCeres(schedule, problem);
    return;
  }
  chains_.clear();
  for (JointChain& chain : problem->joints) chains_.push_back(&chain);
  for (const SolveReport& report :
       chain_solver_.Solve(*problem, schedule, chains_)) {
    Note(report, solver_ == GraphSolver::kBlockTridiagonal
                     ? Result::kTakenOver
                     : Result::kOnlyAStart);
  }
}

void PersonSolver::SolveJointsWithCeres(const SolveSchedule& schedule,
                                        PersonProblem* problem) {
  std::vector<BoneConstraint> bones;
  PersonPrior prior;
  std::vector<PlacedFactor> user;
  const auto exchange_couplings = [&] {
    std::swap(bones, problem->bones);
    std::swap(prior, problem->prior);
    std::swap(user, problem->user);
  };
  exchange_couplings();
  for (JointChain& chain : problem->joints) GateMeasurements(&chain);
  Note(ceres_start_.Solve(schedule, problem), Result::kOnlyAStart);
  exchange_couplings();
}

void PersonSolver::SolveBones(PersonProblem* problem) {
  if (start_ == GraphStart::kDlt) return;
  if (problem->bones.empty() && problem->prior.empty()) return;
  const SolveReport report = bone_solver_.Solve(last_stage_, problem);
  Note(report, solver_ == GraphSolver::kBlockTridiagonal ? Result::kTakenOver
                                                         : Result::kOnlyAStart);
  if (!report.finite) DropBones(problem);
}

void PersonSolver::Refine(PersonProblem* problem) {
  if (solver_ != GraphSolver::kCeres) return;
  const SolveReport report = ceres_solver_.Solve(last_stage_, problem);
  Note(report, Result::kTakenOver);
  // With graph.start = "dlt" no earlier solve has included the bones.
  if (report.finite || start_ != GraphStart::kDlt) return;
  DropBones(problem);
}

void PersonSolver::DropBones(PersonProblem* problem) {
  if (problem->bones.empty()) return;
  ++counts_.bones_dropped;
  problem->bones.clear();
}

void PersonSolver::SolveJointsAndRefine(PersonProblem* problem) {
  if (start_ != GraphStart::kDlt || problem->coupled()) {
    SolveJoints(schedule_, problem);
    Refine(problem);
    return;
  }
  for (JointChain& chain : problem->joints) GateMeasurements(&chain);
  Note(ceres_solver_.Solve(schedule_, problem), Result::kTakenOver);
}

std::vector<std::vector<Matrix6d>> PersonSolver::BoneCovariances(
    const PersonProblem& problem, size_t frame_end) {
  std::vector<std::vector<Matrix6d>> covariances;
  if (!PersonCovariances(problem, correction_, frame_end, &covariances)) {
    ++counts_.no_covariance;
    covariances.assign(problem.joints.size(), {});
  }
  return covariances;
}

std::vector<std::vector<Matrix6d>> PersonSolver::JointCovariances(
    const PersonProblem& problem, double correction, size_t frame_end) {
  std::vector<const JointChain*> chains;
  for (const JointChain& chain : problem.joints) chains.push_back(&chain);
  auto covariances =
      chain_solver_.Covariances(problem, chains, correction, frame_end);
  if (std::any_of(covariances.begin(), covariances.end(),
                  [](const auto& joint) { return joint.empty(); })) {
    ++counts_.no_covariance;
  }
  return covariances;
}

void PersonSolver::Note(const SolveReport& report, Result result) {
  counts_.sweep_iterations += report.iterations;
  counts_.ceres_iterations += report.ceres_iterations;
  counts_.ceres_problems += report.ceres_problems;
  if (result != Result::kTakenOver) return;
  ++counts_.solves;
  if (!report.finite) {
    ++counts_.not_finite;
    return;
  }
  counts_.ceres_decrease_millionths += std::llround(1e6 * report.cost_decrease);
  if (!report.converged) ++counts_.not_converged;
  counts_.positions_in_doubt += report.unsettled;
}

void PersonSolver::FreeWorkSpace() {
  chain_solver_ = ChainSolver();
  bone_solver_ = BoneSolver();
  ceres_solver_ = CeresSolver();
  ceres_start_ = CeresSolver();
}

SolveCounts PersonSolver::ExtractCounts() {
  return std::exchange(counts_, SolveCounts());
}

void PersonSolver::HandInCounts(int64_t first_frame, int64_t last_frame) {
  const SolveCounts counts = ExtractCounts();
  if (ledger_ != nullptr) ledger_->Add(counts, first_frame, last_frame);
  if (counts.AllWell()) return;
  const std::string line = "a person in frames " + std::to_string(first_frame) +
                           " to " + std::to_string(last_frame) + ", " +
                           DescribeTroubles(counts);
  // Slow convergence of the reweighting alone does not deserve a warning;
  // states that were still moving far do.
  if (counts.positions_in_doubt + counts.not_finite + counts.no_covariance >
      0) {
    LOG(WARNING) << line;
  } else {
    VLOG(1) << line;
  }
}

}  // namespace kinegraph
