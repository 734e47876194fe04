#include "solvers/graph/chain_solver.h"

#include <algorithm>
#include <utility>

#include "solvers/graph/damping.h"

namespace kinegraph {
namespace {

template <int N>
double LargestMove(const std::vector<Eigen::Matrix<double, N, 1>>& step) {
  double largest = 0.0;
  for (const auto& state : step) {
    largest = std::max(largest, state.template head<3>().cwiseAbs().maxCoeff());
  }
  return largest;
}

}  // namespace

template <int N>
bool ChainSolverOf<N>::RunStage(const std::vector<TimeNs>& times,
                                const SolveStage& stage,
                                double step_tolerance_m,
                                const JointChain& chain, SolveReport* report) {
  const size_t count = states_.size();
  if (!Linearise<N>(times, chain, states_, stage, true, &linear_)) {
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
      candidate_[k] = states_[k] + step_[k];
    }
    const double move = LargestMove<N>(step_);
    const bool valid =
        Linearise<N>(times, chain, candidate_, stage, true, &trial_);
    if (!valid || !damping.Accepts(linear_.cost, trial_.cost)) {
      if (!damping.Raise()) break;
      continue;
    }
    damping.Lower();
    std::swap(states_, candidate_);
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

template <int N>
SolveReport ChainSolverOf<N>::Solve(const std::vector<TimeNs>& times,
                                    const SolveSchedule& schedule,
                                    JointChain* chain) {
  SolveReport report;
  if (chain->states.empty()) return report;
  const size_t count = chain->states.size();
  states_.resize(count);
  for (size_t k = 0; k < count; ++k) {
    states_[k].template head<6>() = chain->states[k];
    if constexpr (N == 9) {
      states_[k].template tail<3>() = chain->accelerations[k];
    }
  }
  step_.assign(count, Vector::Zero());
  LineariseMotion<N>(times, chain->process_noise, &linear_);
  for (const SolveStage& stage : schedule.stages) {
    if (!RunStage(times, stage, schedule.step_tolerance_m, *chain, &report)) {
      report.finite = report.converged = false;
      break;
    }
  }
  for (size_t k = 0; k < count; ++k) {
    chain->states[k] = states_[k].template head<6>();
    if constexpr (N == 9) {
      chain->accelerations[k] = states_[k].template tail<3>();
    }
  }
  if (report.finite && !report.converged && schedule.doubt_unsettled) {
    last_step_.resize(count);
    for (size_t k = 0; k < count; ++k) {
      last_step_[k] = step_[k].template head<6>();
    }
    report.unsettled = DoubtUnsettled(last_step_, *chain, &linear_.weights);
  }
  for (size_t m = 0; m < chain->measurements.size(); ++m) {
    chain->measurements[m].weight = report.finite ? linear_.weights[m] : 0.0;
  }
  return report;
}

template <int N>
bool ChainSolverOf<N>::Covariances(const std::vector<TimeNs>& times,
                                   const JointChain& chain, double correction,
                                   std::vector<Matrix6d>* covariances) {
  covariances->resize(times.size());
  LineariseMotion<N>(times, chain.process_noise, &linear_);
  LineariseInformation<N>(times, chain, correction, true, &linear_);
  if (!factor_.Factorise(linear_.diagonal, linear_.upper)) return false;
  factor_.SelectedInverse(
      [&](size_t k, const Eigen::Matrix<double, N, N>& block) {
        (*covariances)[k] = block.template topLeftCorner<6, 6>();
      });
  return true;
}

template class ChainSolverOf<6>;
template class ChainSolverOf<9>;

}  // namespace kinegraph
