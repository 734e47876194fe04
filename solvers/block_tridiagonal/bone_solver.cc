#include "solvers/block_tridiagonal/bone_solver.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <type_traits>
#include <utility>

#include "core/base/pack.h"
#include "core/base/stop_check.h"
#include "solvers/block_tridiagonal/lane_blocks.h"
#include "solvers/graph/factor_list.h"

namespace kinegraph {
namespace {

// Index of entry (row, column) of a symmetric 6x6 in a LaneBlock.
int PlaceInBlock(int row, int column) {
  if (row > column) std::swap(row, column);
  if (column < 3) return kSymmetric[row][column];
  if (row >= 3) return 15 + kSymmetric[row - 3][column - 3];
  return 6 + 3 * row + column - 3;
}

// Accuracy of a linear solve, relative to the gradient; the next step corrects
// the rest. A tenth far from the minimum, a hundredth near it, so that a short
// step implies convergence.
constexpr double kNear = 0.01;
constexpr double kFar = 0.1;

// Remaining distance in units of the last step, where reweighting converges
// linearly: the rest of a geometric series. 0 where two successive steps are
// not parallel, or shrink so fast that extrapolation gains nothing.
double StepsToCome(double before_squared, double now_squared, double product) {
  constexpr double kParallel = 0.9;  // cosine
  constexpr double kSlow = 0.3;
  constexpr double kMost = 0.95;  // 19 steps
  const double before = std::sqrt(before_squared);
  const double now = std::sqrt(now_squared);
  if (product < kParallel * before * now || now < kSlow * before) return 0.0;
  const double ratio = std::min(now / before, kMost);
  return ratio / (1.0 - ratio);
}

}  // namespace

void BoneSolver::Load(const PersonProblem& problem) {
  std::vector<const JointChain*> chains;
  for (const JointChain& chain : problem.joints) chains.push_back(&chain);
  const int lanes = PaddedLanes(static_cast<int>(chains.size()));
  lanes_.Load(problem, chains, lanes);
  const size_t frames = lanes_.frames();
  for (System* system : {&system_, &trial_}) {
    system->diagonal.Reserve(lanes_.Row(kLaneBlockSize * frames));
    system->gradient.Reserve(lanes_.Row(6 * frames));
    system->costs.Reserve(lanes);
    system->valid.Reserve(lanes);
  }
  for (LaneBuffer* buffer : {&candidate_, &step_, &before_}) {
    buffer->Assign(lanes_.Row(6 * frames), 0.0);
  }
  const int frame_count = static_cast<int>(frames);
  workspace_.Reserve(std::max(LaneWorkspaceSize(frame_count),
                              CoupledWorkspaceSize(frame_count, lanes)));
  LoadPrior(problem.prior);
}

void BoneSolver::LoadPrior(const PersonPrior& prior) {
  prior_own_.resize(0, 0);
  prior_cross_.resize(0, 0);
  if (prior.empty()) return;
  const auto lanes = static_cast<Eigen::Index>(lanes_.lanes());
  const Eigen::Index size = prior.A.cols();
  const Eigen::MatrixXd& information = prior.information;
  prior_own_.setZero(lanes, kLaneBlockSize);
  prior_cross_.setZero(6 * lanes, size);
  for (Eigen::Index column = 0; column < size; ++column) {
    for (Eigen::Index row = 0; row < size; ++row) {
      const int i = static_cast<int>(row % 6);
      const int j = static_cast<int>(column % 6);
      if (row / 6 == column / 6) {
        prior_own_(row / 6, PlaceInBlock(i, j)) = information(row, column);
      } else {
        prior_cross_(i * lanes + row / 6, column) = information(row, column);
      }
    }
  }
  // Keeps lanes without a joint non-singular.
  for (Eigen::Index lane = size / 6; lane < lanes; ++lane) {
    for (int i = 0; i < 6; ++i) prior_own_(lane, PlaceInBlock(i, i)) = 1.0;
  }
}

ChainLanes BoneSolver::At(LaneBuffer* states) const {
  ChainLanes chains = lanes_.arrays();
  chains.states = states->data();
  return chains;
}

void BoneSolver::AddCouplings(const PersonProblem& problem,
                              const LaneBuffer& states, System* system) const {
  system->couplings.clear();
  double ends[2][6];
  int end = 0;
  const auto state_of = [&](const StateKey& key) -> const double* {
    end = 1 - end;
    for (size_t i = 0; i < 6; ++i) {
      ends[end][i] = states[lanes_.Row(6 * key.frame + i) + key.joint];
    }
    return ends[end];
  };
  const auto add = [&](const auto& factor, const auto& keys,
                       const Robustness& robustness) {
    using Factor = std::decay_t<decltype(factor)>;
    static_assert(Factor::kResiduals == 1, "a coupling has one residual");
    static_assert(Factor::kKeys == 2, "a coupling has two ends");
    Linearised<Factor> at;
    if (!LineariseFactor(factor, keys, state_of, &at)) return false;
    const LossValue loss = robustness.Evaluate(at.squared_norm());
    system->cost += 0.5 * robustness.information * loss.rho;
    const double weight = robustness.information * loss.first;
    // Includes the second derivative of a stretched bone (Swing, factors.h).
    const double swing = factor.Swing(at.residual[0]);
    const double resistance = swing * factor.per_sigma * factor.per_sigma;
    const auto information = [&](int i, int row, int j, int column) {
      const double along = at.by_states[i](0, row) * at.by_states[j](0, column);
      const double across = row != column ? 0.0 : i == j ? 1.0 : -1.0;
      return weight * ((1.0 - swing) * along + resistance * across);
    };
    LaneCoupling coupling;
    coupling.frame = static_cast<int>(keys[0].frame);
    coupling.a = keys[0].joint;
    coupling.b = keys[1].joint;
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) {
        coupling.block[row][column] = information(0, row, 1, column);
      }
    }
    for (int i = 0; i < 2; ++i) {
      const size_t frame = keys[i].frame;
      const size_t lane = keys[i].joint;
      double gradient[6] = {};
      AddGradient(at.by_states[i], at.residual, weight, gradient);
      for (int row = 0; row < 3; ++row) {
        system->gradient[lanes_.Row(6 * frame + row) + lane] += gradient[row];
        for (int column = row; column < 3; ++column) {
          system->diagonal[lanes_.Row(kLaneBlockSize * frame +
                                      kSymmetric[row][column]) +
                           lane] += information(i, row, i, column);
        }
      }
    }
    system->couplings.push_back(coupling);
    return true;
  };
  ForEachCoupling(problem, FactorWalk(), add);
}

void BoneSolver::AddPrior(const PersonPrior& prior, const LaneBuffer& states,
                          System* system) const {
  const Eigen::Index size = prior.A.cols();
  Eigen::VectorXd away = -prior.x0;
  for (Eigen::Index row = 0; row < size; ++row) {
    away[row] += states[lanes_.Row(row % 6) + row / 6];
  }
  const Eigen::VectorXd residual =
      prior.A.triangularView<Eigen::Upper>() * away + prior.b;
  const Eigen::VectorXd gradient =
      prior.A.triangularView<Eigen::Upper>().transpose() * residual;
  system->cost += 0.5 * residual.squaredNorm();
  for (Eigen::Index row = 0; row < size; ++row) {
    system->gradient[lanes_.Row(row % 6) + row / 6] += gradient[row];
  }
  for (size_t i = 0; i < lanes_.Row(kLaneBlockSize); ++i) {
    system->diagonal[i] += prior_own_.data()[i];
  }
}

bool BoneSolver::Linearise(const PersonProblem& problem,
                           const SolveStage& stage, LaneBuffer* states,
                           System* system) {
  CurrentLaneKernels().linearise(
      At(states), {stage.loss, stage.scale, stage.max_iterations},
      problem.prior.empty(), workspace_.data(), system->rows());
  system->cost = 0.0;
  for (size_t j = 0; j < problem.joints.size(); ++j) {
    if (system->valid[j] == 0.0) return false;
    system->cost += system->costs[j];
  }
  AddCouplings(problem, *states, system);
  if (!problem.prior.empty()) AddPrior(problem.prior, *states, system);
  return std::isfinite(system->cost);
}

bool BoneSolver::FindStep(double damping, double accuracy) {
  const LaneCouplings couplings = {
      system_.couplings.data(), static_cast<int>(system_.couplings.size()),
      prior_cross_.size() > 0 ? prior_cross_.data() : nullptr};
  return CurrentLaneKernels().solve_coupled(lanes_.arrays(), system_.rows(),
                                            couplings, damping, accuracy,
                                            workspace_.data(), step_.data());
}

double BoneSolver::MoveCandidate(double scale) {
  const LaneBuffer& states = lanes_.states();
  double largest_m = 0.0;
  for (size_t row = 0; row < 6 * lanes_.frames(); ++row) {
    for (size_t at = lanes_.Row(row); at < lanes_.Row(row + 1); ++at) {
      const double move = scale * step_[at];
      candidate_[at] = states[at] + move;
      if (row % 6 < 3) largest_m = std::max(largest_m, std::abs(move));
    }
  }
  return largest_m;
}

void BoneSolver::KeepCandidate() {
  std::swap(lanes_.states(), candidate_);
  std::swap(system_, trial_);
}

double BoneSolver::Dot(const LaneBuffer& a, const LaneBuffer& b) const {
  return std::inner_product(
      a.data(), a.data() + lanes_.Row(6 * lanes_.frames()), b.data(), 0.0);
}

void BoneSolver::LeapAhead(const PersonProblem& problem,
                           const SolveStage& stage) {
  const double now_squared = Dot(step_, step_);
  const double to_come =
      before_squared_ > 0.0
          ? StepsToCome(before_squared_, now_squared, Dot(before_, step_))
          : 0.0;
  std::copy_n(step_.data(), lanes_.Row(6 * lanes_.frames()), before_.data());
  before_squared_ = now_squared;
  if (to_come == 0.0) return;
  MoveCandidate(to_come);
  if (!Linearise(problem, stage, &candidate_, &trial_) ||
      !(trial_.cost < system_.cost)) {
    return;
  }
  KeepCandidate();
  before_squared_ = 0.0;
}

bool BoneSolver::RunStage(const PersonProblem& problem, const SolveStage& stage,
                          double step_tolerance_m, SolveReport* report) {
  constexpr double kFarM = 1e-3;  // a longer step is far from the minimum
  if (!Linearise(problem, stage, &lanes_.states(), &system_)) return false;
  // Levenberg-Marquardt, undamped until a step fails to lower the cost.
  double damping = 0.0;
  // Raises the damping; false if it exceeds the limit.
  const auto raise = [&damping] {
    damping = damping > 0.0 ? 10.0 * damping : 1e-4;
    return damping < 1e10;
  };
  double accuracy = kFar;
  before_squared_ = 0.0;
  report->converged = false;
  for (int iteration = 0; iteration < stage.max_iterations; ++iteration) {
    CheckStop();
    ++report->iterations;
    if (!FindStep(damping, accuracy)) {
      if (!raise()) break;
      continue;
    }
    const double move_m = MoveCandidate(1.0);
    // Near a minimum rounding may raise the cost by a part in 1e12.
    const double most = system_.cost + 1e-12 * (1.0 + system_.cost);
    if (!Linearise(problem, stage, &candidate_, &trial_) ||
        !(trial_.cost <= most)) {
      if (!raise()) break;
      continue;
    }
    damping = damping > 1e-6 ? 0.1 * damping : 0.0;
    KeepCandidate();
    const bool settled = move_m < step_tolerance_m && accuracy == kNear;
    accuracy = move_m > kFarM ? kFar : kNear;
    if (settled) {
      report->converged = true;
      break;
    }
    LeapAhead(problem, stage);
  }
  return true;
}

void BoneSolver::Unload(const SolveSchedule& schedule, SolveReport* report,
                        PersonProblem* problem) {
  const SolveStage& last = schedule.stages.back();
  CurrentLaneKernels().weigh(At(&lanes_.states()),
                             {last.loss, last.scale, last.max_iterations},
                             workspace_.data());
  for (size_t j = 0; j < problem->joints.size(); ++j) {
    JointChain& chain = problem->joints[j];
    lanes_.Unload(j, &chain);
    if (report->converged || !schedule.doubt_unsettled) continue;
    report->unsettled += DoubtUnsettled(lanes_.ChainOf(step_, j), &chain);
  }
}

bool BoneSolver::AllFinite() {
  const double* const first = lanes_.states().data();
  return std::all_of(first, first + lanes_.Row(6 * lanes_.frames()),
                     [](double value) { return std::isfinite(value); });
}

SolveReport BoneSolver::Solve(const SolveSchedule& schedule,
                              PersonProblem* problem) {
  SolveReport report;
  Load(*problem);
  if (!Linearise(*problem, schedule.stages.front(), &lanes_.states(),
                 &system_)) {
    // ChainSolver does not check the last step of a stage, which may have moved
    // a joint behind a camera.
    for (JointChain& chain : problem->joints) GateMeasurements(&chain);
    Load(*problem);
  }
  for (const SolveStage& stage : schedule.stages) {
    if (!RunStage(*problem, stage, schedule.step_tolerance_m, &report) ||
        !AllFinite()) {
      report.finite = report.converged = false;
      return report;
    }
  }
  Unload(schedule, &report, problem);
  return report;
}

}  // namespace kinegraph
