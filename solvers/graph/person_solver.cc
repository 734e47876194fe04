#include "solvers/graph/person_solver.h"

#include <glog/logging.h>

#include <string>
#include <utility>

#include "solvers/graph/ceres_solver.h"
#include "solvers/graph/schedule.h"

namespace kinegraph {
namespace {

bool AllFinite(const std::vector<State>& states) {
  for (const State& state : states) {
    if (!state.allFinite()) return false;
  }
  return true;
}

// Ceres works on a person: one with this joint alone.
SolveReport SolveOneWithCeres(const SolveSchedule& schedule,
                              const std::vector<TimeNs>& times,
                              JointChain* chain) {
  PersonProblem alone;
  alone.times = times;
  alone.joints.push_back(std::move(*chain));
  const SolveReport report = SolveWithCeres(schedule, &alone);
  *chain = std::move(alone.joints.front());
  return report;
}

// Reweighting may creep for longer than it is worth; a state that still moves
// far is another matter.
void LogUnsettled(const std::string& what, const SolveReport& report) {
  if (report.converged) return;
  if (report.unsettled > 0) {
    LOG(WARNING) << what << ": not settled after " << report.iterations
                 << " iterations, " << report.unsettled
                 << " states are not to be trusted";
  } else {
    VLOG(1) << what << ": not settled after " << report.iterations
            << " iterations";
  }
}

}  // namespace

PersonSolver::PersonSolver(const GraphOptions& options)
    : solver_(options.solver),
      schedule_(MakeSchedule(options)),
      correction_(InformationCorrection(schedule_.stages.back().loss,
                                        schedule_.stages.back().scale)) {}

void PersonSolver::SolveJoint(const SolveSchedule& schedule, int joint_idx,
                              PersonProblem* problem) {
  JointChain& chain = problem->joints[joint_idx];
  GateMeasurements(&chain);
  start_ = chain.states;
  const SolveReport report =
      solver_ == GraphSolver::kCeres
          ? SolveOneWithCeres(schedule, problem->times, &chain)
          : chain_solver_.Solve(problem->times, schedule, &chain);
  if (report.finite && AllFinite(chain.states)) {
    LogUnsettled("joint " + std::to_string(joint_idx), report);
    return;
  }
  LOG(WARNING) << "joint " << joint_idx
               << ": the solver found no finite estimate";
  chain.states = start_;
  for (PixelMeasurement& measurement : chain.measurements) {
    measurement.weight = 0.0;
  }
}

void PersonSolver::SolveBones(PersonProblem* problem) {
  if (problem->bones.empty() && problem->prior.empty()) return;
  SolveSchedule last = schedule_;
  last.stages.erase(last.stages.begin(), last.stages.end() - 1);
  PersonProblem coupled = *problem;
  const SolveReport report = solver_ == GraphSolver::kCeres
                                 ? SolveWithCeres(last, &coupled)
                                 : bone_solver_.Solve(last, &coupled);
  bool finite = report.finite;
  for (const JointChain& chain : coupled.joints) {
    finite = finite && AllFinite(chain.states);
  }
  if (!finite) {
    LOG(WARNING) << "bones: the solver found no finite estimate";
    // Covariances must not count what the estimates did not.
    problem->bones.clear();
    return;
  }
  LogUnsettled("bones", report);
  *problem = std::move(coupled);
}

std::vector<std::vector<Matrix6d>> PersonSolver::BoneCovariances(
    const PersonProblem& problem, size_t frame_end) const {
  std::vector<std::vector<Matrix6d>> covariances;
  if (!PersonCovariances(problem, correction_, frame_end, &covariances)) {
    LOG(WARNING) << "bones: no covariance";
    covariances.assign(problem.joints.size(), {});
  }
  return covariances;
}

const std::vector<Matrix6d>& PersonSolver::JointCovariances(
    const PersonProblem& problem, int joint_idx, double correction) {
  if (!chain_solver_.Covariances(problem.times, problem.joints[joint_idx],
                                 correction, &covariances_)) {
    LOG(WARNING) << "joint " << joint_idx << ": no covariance";
    covariances_.clear();
  }
  return covariances_;
}

}  // namespace kinegraph
