#include "solvers/sweeps/chain_solver.h"

#include <algorithm>
#include <utility>

#include "solvers/sweeps/damping.h"

namespace kinegraph {
namespace {

double LargestMove(const StateChain& step) {
  double largest = 0.0;
  for (const State& state : step) {
    largest = std::max(largest, state.head<3>().cwiseAbs().maxCoeff());
  }
  return largest;
}

}  // namespace

bool ChainSolver::RunStage(const std::vector<TimeNs>& times,
                           const SolveStage& stage, double step_tolerance_m,
                           const JointChain& chain, SolveReport* report) {
  const size_t count = states_.size();
  if (!Linearise(times, chain, states_, stage, true, &linear_)) return false;
  Damping damping;
  report->converged = false;
  for (int iteration = 0; iteration < stage.max_iterations; ++iteration) {
    ++report->iterations;
    if (!factor_.Factorise(linear_.diagonal, linear_.upper, damping.value())) {
      if (!damping.Raise()) break;
      continue;
    }
    for (size_t k = 0; k < count; ++k) step_[k] = -linear_.gradient[k];
    factor_.Solve(&step_);
    candidate_.resize(count);
    for (size_t k = 0; k < count; ++k) candidate_[k] = states_[k] + step_[k];
    const double move = LargestMove(step_);
    const bool valid =
        Linearise(times, chain, candidate_, stage, true, &trial_);
    if (!valid || !damping.Accepts(linear_.cost, trial_.cost)) {
      if (!damping.Raise()) break;
      continue;
    }
    damping.Lower();
    std::swap(states_, candidate_);
    std::swap(linear_, trial_);
    if (move < step_tolerance_m) {
      report->converged = true;
      break;
    }
  }
  return true;
}

SolveReport ChainSolver::Solve(const std::vector<TimeNs>& times,
                               const SolveSchedule& schedule,
                               JointChain* chain) {
  SolveReport report;
  if (chain->states.empty()) return report;
  states_ = chain->states;
  step_.assign(states_.size(), State::Zero());
  for (const SolveStage& stage : schedule.stages) {
    if (!RunStage(times, stage, schedule.step_tolerance_m, *chain, &report)) {
      report.finite = report.converged = false;
      break;
    }
  }
  chain->states = states_;
  for (size_t m = 0; m < chain->measurements.size(); ++m) {
    chain->measurements[m].weight = report.finite ? linear_.weights[m] : 0.0;
  }
  if (report.finite && !report.converged && schedule.doubt_unsettled) {
    report.unsettled = DoubtUnsettled(step_, chain);
  }
  return report;
}

bool ChainSolver::Covariances(const std::vector<TimeNs>& times,
                              const JointChain& chain, double correction,
                              std::vector<Matrix6d>* covariances) {
  covariances->resize(times.size());
  LineariseInformation(times, chain, correction, true, &linear_);
  if (!factor_.Factorise(linear_.diagonal, linear_.upper)) return false;
  factor_.SelectedInverse(
      [&](size_t k, const Matrix6d& block) { (*covariances)[k] = block; });
  return true;
}

}  // namespace kinegraph
