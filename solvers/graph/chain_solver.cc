#include "solvers/graph/chain_solver.h"

#include <algorithm>
#include <utility>

#include "solvers/graph/damping.h"

namespace kinegraph {
namespace {

double LargestMove(const std::vector<State>& step) {
  double largest = 0.0;
  for (const State& state : step) {
    largest = std::max(largest, state.head<3>().cwiseAbs().maxCoeff());
  }
  return largest;
}

}  // namespace

bool ChainSolver::RunStage(const std::vector<TimeNs>& times,
                           const SolveStage& stage, double step_tolerance_m,
                           JointChain* chain, SolveReport* report) {
  const size_t count = chain->states.size();
  if (!Linearise(times, *chain, chain->states, stage, true, &linear_)) {
    return false;
  }
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
    for (size_t k = 0; k < count; ++k) {
      candidate_[k] = chain->states[k] + step_[k];
    }
    const double move = LargestMove(step_);
    const bool valid =
        Linearise(times, *chain, candidate_, stage, true, &trial_);
    if (!valid || !damping.Accepts(linear_.cost, trial_.cost)) {
      if (!damping.Raise()) break;
      continue;
    }
    damping.Lower();
    std::swap(chain->states, candidate_);
    std::swap(linear_.diagonal, trial_.diagonal);
    std::swap(linear_.gradient, trial_.gradient);
    std::swap(linear_.weights, trial_.weights);
    linear_.cost = trial_.cost;
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
  step_.assign(chain->states.size(), State::Zero());
  LineariseMotion(times, chain->process_noise, &linear_);
  for (const SolveStage& stage : schedule.stages) {
    if (!RunStage(times, stage, schedule.step_tolerance_m, chain, &report)) {
      report.finite = report.converged = false;
      break;
    }
  }
  if (report.finite && !report.converged && schedule.doubt_unsettled) {
    report.unsettled = DoubtUnsettled(step_, *chain, &linear_.weights);
  }
  for (size_t m = 0; m < chain->measurements.size(); ++m) {
    chain->measurements[m].weight = report.finite ? linear_.weights[m] : 0.0;
  }
  return report;
}

bool ChainSolver::Covariances(const std::vector<TimeNs>& times,
                              const JointChain& chain, double correction,
                              std::vector<Matrix6d>* covariances) {
  covariances->resize(times.size());
  LineariseMotion(times, chain.process_noise, &linear_);
  LineariseInformation(times, chain, correction, true, &linear_);
  if (!factor_.Factorise(linear_.diagonal, linear_.upper)) return false;
  factor_.SelectedInverse(
      [&](size_t k, const Matrix6d& block) { (*covariances)[k] = block; });
  return true;
}

}  // namespace kinegraph
