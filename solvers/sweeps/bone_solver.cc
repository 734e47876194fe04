#include "solvers/sweeps/bone_solver.h"

#include <algorithm>
#include <utility>

#include "solvers/graph/creep.h"
#include "solvers/sweeps/damping.h"

namespace kinegraph {
namespace {

void Resize(size_t joints, size_t frames, PersonStates* states) {
  states->resize(joints);
  for (std::vector<State>& joint : *states) joint.resize(frames);
}

double LargestMove(const PersonStates& step) {
  double largest = 0.0;
  for (const std::vector<State>& joint : step) {
    for (const State& state : joint) {
      largest = std::max(largest, state.head<3>().cwiseAbs().maxCoeff());
    }
  }
  return largest;
}

}  // namespace

bool BoneSolver::Precondition(double damping) {
  factors_.resize(system_.chains.size());
  for (size_t j = 0; j < factors_.size(); ++j) {
    const LinearChain& chain = system_.chains[j];
    if (!factors_[j].Factorise(chain.diagonal, chain.upper, damping)) {
      return false;
    }
  }
  return true;
}

void BoneSolver::SolveLinear(double damping) {
  // Gauss-Newton corrects what is left, so the systems need not be exact.
  constexpr double kRelative = 1e-3;  // of the residual, in the chains' norm
  constexpr int kMaxIterations = 100;
  for (size_t j = 0; j < step_.size(); ++j) {
    for (size_t k = 0; k < step_[j].size(); ++k) {
      step_[j][k].setZero();
      residual_[j][k] = -system_.chains[j].gradient[k];
    }
  }
  double before = 0.0;
  double first = 0.0;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    conditioned_ = residual_;
    for (size_t j = 0; j < factors_.size(); ++j) {
      factors_[j].Solve(&conditioned_[j]);
    }
    const double now = Dot(residual_, conditioned_);
    if (iteration == 0) first = now;
    if (!(now > kRelative * kRelative * first)) return;
    if (iteration == 0) {
      direction_ = conditioned_;
    } else {
      const double turn = now / before;
      for (size_t j = 0; j < direction_.size(); ++j) {
        for (size_t k = 0; k < direction_[j].size(); ++k) {
          direction_[j][k] = conditioned_[j][k] + turn * direction_[j][k];
        }
      }
    }
    before = now;
    Multiply(system_, damping, direction_, &product_);
    const double curvature = Dot(direction_, product_);
    if (!(curvature > 0.0)) return;
    AddScaled(now / curvature, direction_, &step_);
    AddScaled(-now / curvature, product_, &residual_);
  }
}

bool BoneSolver::RunStage(const SolveStage& stage, double step_tolerance_m,
                          PersonProblem* problem, SolveReport* report) {
  if (!Linearise(*problem, states_, stage, &system_)) return false;
  Damping damping;
  report->converged = false;
  previous_step_.clear();
  for (int iteration = 0; iteration < stage.max_iterations; ++iteration) {
    ++report->iterations;
    if (!Precondition(damping.value())) {
      if (!damping.Raise()) break;
      continue;
    }
    SolveLinear(damping.value());
    candidate_ = states_;
    AddScaled(1.0, step_, &candidate_);
    const double move = LargestMove(step_);
    const bool valid = Linearise(*problem, candidate_, stage, &trial_);
    if (!valid || !damping.Accepts(system_.cost, trial_.cost)) {
      if (!damping.Raise()) break;
      continue;
    }
    damping.Lower();
    std::swap(states_, candidate_);
    std::swap(system_, trial_);
    if (move < step_tolerance_m) {
      report->converged = true;
      break;
    }
    LeapAhead(stage, problem);
  }
  return true;
}

void BoneSolver::LeapAhead(const SolveStage& stage, PersonProblem* problem) {
  const double to_come =
      previous_step_.empty() ? 0.0 : StepsToCome(previous_step_, step_);
  previous_step_ = step_;
  if (to_come == 0.0) return;
  candidate_ = states_;
  AddScaled(to_come, step_, &candidate_);
  if (!Linearise(*problem, candidate_, stage, &trial_)) return;
  if (!(trial_.cost < system_.cost)) return;
  std::swap(states_, candidate_);
  std::swap(system_, trial_);
  previous_step_.clear();
}

SolveReport BoneSolver::Solve(const SolveSchedule& schedule,
                              PersonProblem* problem) {
  SolveReport report;
  const size_t joints = problem->joints.size();
  const size_t frames = problem->times.size();
  if (frames == 0) return report;
  for (PersonStates* states : {&step_, &residual_, &product_}) {
    Resize(joints, frames, states);
  }
  for (std::vector<State>& joint : step_) {
    std::fill(joint.begin(), joint.end(), State::Zero());
  }
  system_.prior_coupling = PriorCoupling(problem->prior.A);
  trial_.prior_coupling = system_.prior_coupling;
  states_ = StatesOf(*problem);
  for (const SolveStage& stage : schedule.stages) {
    if (!RunStage(stage, schedule.step_tolerance_m, problem, &report)) {
      report.finite = report.converged = false;
      return report;
    }
  }
  for (size_t j = 0; j < joints; ++j) {
    JointChain& chain = problem->joints[j];
    chain.states = states_[j];
    for (size_t m = 0; m < chain.measurements.size(); ++m) {
      chain.measurements[m].weight = system_.chains[j].weights[m];
    }
    if (!report.converged && schedule.doubt_unsettled) {
      report.unsettled += DoubtUnsettled(step_[j], &chain);
    }
  }
  return report;
}

}  // namespace kinegraph
