#include "solvers/person/person_solver.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "solvers/block_tridiagonal/person_system.h"
#include "solvers/ceres/ceres_solver.h"
#include "solvers/graph/assembler.h"

namespace kinegraph {
namespace {

bool AllFinite(const StateChain& states) {
  for (const State& state : states) {
    if (!state.allFinite()) return false;
  }
  return true;
}

bool AllFinite(const PersonProblem& problem) {
  for (const JointChain& chain : problem.joints) {
    if (!AllFinite(chain.states)) return false;
  }
  return true;
}

SolveSchedule LastStage(SolveSchedule schedule) {
  schedule.stages.erase(schedule.stages.begin(), schedule.stages.end() - 1);
  return schedule;
}

}  // namespace

PersonSolver::PersonSolver(const GraphOptions& options)
    : solver_(options.solver),
      ledger_(options.ledger),
      schedule_(MakeSchedule(options)),
      correction_(InformationCorrection(
          schedule_.stages.back().loss,
          schedule_.stages.back().scale *
              (options.pixel_noise_from == NoiseFrom::kRecording
                   ? kLearntWidening
                   : 1.0))) {}

void PersonSolver::SolveJoints(const SolveSchedule& schedule,
                               const std::vector<int>& joint_indices,
                               PersonProblem* problem) {
  std::vector<JointChain*> chains;
  std::vector<StateChain> starts;
  for (const int j : joint_indices) {
    chains.push_back(&problem->joints[j]);
    starts.push_back(chains.back()->states);
  }
  const std::vector<SolveReport> reports =
      chain_solver_.Solve(problem->times, schedule, chains);
  for (size_t i = 0; i < chains.size(); ++i) {
    Finish(reports[i], starts[i], chains[i]);
  }
}

void PersonSolver::Finish(SolveReport report, const StateChain& start,
                          JointChain* chain) {
  report.finite = report.finite && AllFinite(chain->states);
  Note(report, solver_ == GraphSolver::kBlockTridiagonal ? Result::kTakenOver
                                                         : Result::kOnlyAStart);
  if (report.finite) return;
  chain->states = start;
  for (PixelMeasurement& measurement : chain->measurements) {
    measurement.weight = 0.0;
  }
}

void PersonSolver::SolveBones(PersonProblem* problem) {
  if (problem->bones.empty() && problem->prior.empty()) return;
  SolveSchedule schedule = LastStage(schedule_);
  // A step of Ceres costs as much as many sweeps: from a third of its tolerance
  // its first one shows that it has settled.
  if (solver_ == GraphSolver::kCeres) schedule.step_tolerance_m /= 3.0;
  PersonProblem coupled = *problem;
  SolveReport report = bone_solver_.Solve(schedule, &coupled);
  report.finite = report.finite && AllFinite(coupled);
  Note(report, solver_ == GraphSolver::kBlockTridiagonal ? Result::kTakenOver
                                                         : Result::kOnlyAStart);
  if (report.finite) {
    *problem = std::move(coupled);
    return;
  }
  // Covariances must not count what the estimates did not.
  ++counts_.bones_dropped;
  problem->bones.clear();
}

void PersonSolver::Refine(PersonProblem* problem) {
  if (solver_ != GraphSolver::kCeres) return;
  const SolveSchedule last = LastStage(schedule_);
  // Chains and bones know nothing of the user's factors.
  if (problem->user.empty() &&
      bone_solver_.IsAtMinimum(*problem, last.stages.back(),
                               last.step_tolerance_m)) {
    SolveReport report;
    report.converged = true;
    Note(report, Result::kTakenOver);
    return;
  }
  // Ceres holds on to the states' addresses; a copy keeps the start.
  const PersonStates start = StatesOf(*problem);
  SolveReport report = SolveWithCeres(last, problem);
  report.finite = report.finite && AllFinite(*problem);
  Note(report, Result::kTakenOver);
  if (report.finite) return;
  for (size_t j = 0; j < start.size(); ++j) {
    problem->joints[j].states = start[j];
    StoreWeights(schedule_.stages.back(), &problem->joints[j]);
  }
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
      chain_solver_.Covariances(problem.times, chains, correction, frame_end);
  for (const std::vector<Matrix6d>& joint : covariances) {
    if (joint.empty()) ++counts_.no_covariance;
  }
  return covariances;
}

void PersonSolver::Note(const SolveReport& report, Result result) {
  counts_.sweep_iterations += report.iterations;
  counts_.ceres_iterations += report.ceres_iterations;
  counts_.ceres_problems += report.ceres_problems;
  if (!report.finite) ++counts_.not_finite;
  if (result != Result::kTakenOver) return;
  ++counts_.solves;
  if (!report.finite) return;
  counts_.ceres_decrease_millionths += std::llround(1e6 * report.cost_decrease);
  if (!report.converged) ++counts_.not_converged;
  counts_.positions_in_doubt += report.unsettled;
}

void PersonSolver::FreeWorkSpace() {
  chain_solver_ = ChainSolver();
  bone_solver_ = BoneSolver();
}

SolveCounts PersonSolver::ExtractCounts() {
  return std::exchange(counts_, SolveCounts());
}

void PersonSolver::HandInCounts(int64_t first_frame, int64_t last_frame) {
  const SolveCounts counts = ExtractCounts();
  if (ledger_ != nullptr) ledger_->Add(counts, first_frame, last_frame);
  if (counts.AllWell()) return;
  const std::string line = "a person of frames " + std::to_string(first_frame) +
                           " to " + std::to_string(last_frame) + ": " +
                           DescribeTroubles(counts);
  // Reweighting may creep for longer than it is worth; a state that still
  // moves far is another matter.
  if (counts.positions_in_doubt + counts.not_finite + counts.no_covariance >
      0) {
    LOG(WARNING) << line;
  } else {
    VLOG(1) << line;
  }
}

}  // namespace kinegraph
