#include "solvers/person/person_solver.h"

#include <glog/logging.h>

#include <algorithm>
#include <sstream>
#include <utility>

#include "solvers/ceres/ceres_solver.h"
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
  SolveReport report;
  if (solver_ == GraphSolver::kCeres) {
    report = SolveOneWithCeres(schedule, problem->times, &chain);
  } else {
    report = chain_solver_.Solve(problem->times, schedule, &chain);
  }
  if (report.finite && AllFinite(chain.states)) {
    Note(report);
    return;
  }
  ++troubles_.solves;
  ++troubles_.not_finite;
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
    ++troubles_.solves;
    ++troubles_.not_finite;
    // Covariances must not count what the estimates did not.
    problem->bones.clear();
    return;
  }
  Note(report);
  *problem = std::move(coupled);
}

std::vector<std::vector<Matrix6d>> PersonSolver::BoneCovariances(
    const PersonProblem& problem, size_t frame_end) {
  std::vector<std::vector<Matrix6d>> covariances;
  if (!PersonCovariances(problem, correction_, frame_end, &covariances)) {
    ++troubles_.no_covariance;
    covariances.assign(problem.joints.size(), {});
  }
  return covariances;
}

const std::vector<Matrix6d>& PersonSolver::JointCovariances(
    const PersonProblem& problem, int joint_idx, double correction) {
  const JointChain& chain = problem.joints[joint_idx];
  const bool known = chain_solver_.Covariances(problem.times, chain, correction,
                                               &covariances_);
  if (!known) {
    ++troubles_.no_covariance;
    covariances_.clear();
  }
  return covariances_;
}

void PersonSolver::Note(const SolveReport& report) {
  ++troubles_.solves;
  if (report.converged) return;
  ++troubles_.not_converged;
  troubles_.unsettled_states += report.unsettled;
}

void PersonSolver::LogTroubles(int64_t first_frame, int64_t last_frame) {
  const Troubles troubles = troubles_;
  troubles_ = Troubles();
  std::ostringstream line;
  line << "a person of frames " << first_frame << " to " << last_frame << ": "
       << troubles.solves << " solves, " << troubles.not_converged
       << " ended before they settled, " << troubles.unsettled_states
       << " joint positions are not to be trusted, " << troubles.not_finite
       << " solves found nothing finite, " << troubles.no_covariance
       << " had no covariance";
  // Reweighting may creep for longer than it is worth; a state that still
  // moves far is another matter.
  if (troubles.unsettled_states + troubles.not_finite + troubles.no_covariance >
      0) {
    LOG(WARNING) << line.str();
  } else if (troubles.not_converged > 0) {
    VLOG(1) << line.str();
  }
}

}  // namespace kinegraph
