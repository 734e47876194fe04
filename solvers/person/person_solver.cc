#include "solvers/person/person_solver.h"

#include <glog/logging.h>

#include <algorithm>
#include <limits>
#include <sstream>
#include <utility>

#include "solvers/ceres/ceres_solver.h"
#include "solvers/graph/noise_model.h"
#include "solvers/graph/schedule.h"
#include "solvers/person/rivals.h"

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
    : rival_starts_(options.rival_starts),
      inlier_weight_(options.inlier_weight),
      solver_(options.solver),
      schedule_(MakeSchedule(options)),
      correction_(InformationCorrection(
          schedule_.stages.back().loss,
          schedule_.stages.back().scale *
              (options.pixel_noise_from == NoiseFrom::kTake ? kLearntWidening
                                                            : 1.0))) {}

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

double PersonSolver::JointCost(const std::vector<TimeNs>& times,
                               const JointChain& chain) {
  const SolveStage& stage = schedule_.stages.back();
  if (!Linearise(times, chain, chain.states, stage, true, &linear_)) {
    return std::numeric_limits<double>::infinity();
  }
  // A view that cannot see the joint costs as one that is far off.
  constexpr double kFar = 1e6;  // sigmas, squared
  double cost = linear_.cost;
  for (const PixelMeasurement& measurement : chain.measurements) {
    if (!measurement.gated) continue;
    cost += 0.5 * measurement.information *
            EvaluateLoss(stage.loss, stage.scale, kFar).rho;
  }
  return cost;
}

void PersonSolver::SolveJointWithRivals(const SolveSchedule& schedule,
                                        int joint_idx, PersonProblem* problem) {
  SolveJoint(schedule, joint_idx, problem);
  JointChain& chain = problem->joints[joint_idx];
  if (!rival_starts_ || IsConvex(schedule.stages.back().loss)) return;
  const std::vector<Stretch> stretches = LostStretches(chain, inlier_weight_);
  if (stretches.empty()) return;
  ++rivals_.cases;
  SolveSchedule last = schedule;
  last.stages.erase(last.stages.begin(), last.stages.end() - 1);
  const JointChain first = chain;
  JointChain best = chain;
  double least = JointCost(problem->times, chain);
  bool taken = false;
  for (const RivalMask mask : {RivalMask::kBelieved, RivalMask::kAll}) {
    chain = first;
    const std::vector<char> masked =
        MaskFor(mask, stretches, inlier_weight_, first);
    for (size_t m = 0; m < masked.size(); ++m) {
      if (masked[m]) chain.measurements[m].information = 0.0;
    }
    SolveJoint(schedule, joint_idx, problem);
    for (size_t m = 0; m < masked.size(); ++m) {
      chain.measurements[m].information = first.measurements[m].information;
    }
    SolveJoint(last, joint_idx, problem);
    const double cost = JointCost(problem->times, chain);
    // Not for the sake of rounding.
    if (!(cost < least - 1e-6 * (1.0 + least))) continue;
    least = cost;
    best = chain;
    taken = true;
  }
  chain = std::move(best);
  if (taken) ++rivals_.taken;
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
       << " had no covariance; " << rivals_.cases
       << " times most views of a joint were lost, " << rivals_.taken
       << " times a rival start was better";
  // Reweighting may creep for longer than it is worth; a state that still
  // moves far is another matter.
  if (troubles.unsettled_states + troubles.not_finite + troubles.no_covariance >
      0) {
    LOG(WARNING) << line.str();
  } else if (troubles.not_converged > 0 || rivals_.cases > 0) {
    VLOG(1) << line.str();
  }
}

}  // namespace kinegraph
