#include "solvers/block_tridiagonal/chain_solver.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/base/stop_check.h"

namespace kinegraph {

void LaneProblem::LoadTimes(const PersonProblem& problem,
                            const std::vector<const JointChain*>& chains) {
  const std::vector<TimeNs>& times = problem.times;
  centres_.clear();
  for (const PersonCentre& centre : problem.centres) {
    centres_.push_back({centre.position_m.x(), centre.position_m.y(),
                        centre.position_m.z(), centre.per_sigma});
  }
  dt_s_.clear();
  process_noise_.Assign(frames_ * lanes_, 1.0);
  for (size_t k = 0; k + 1 < frames_; ++k) {
    dt_s_.push_back(ToSeconds(times[k + 1] - times[k]));
    for (size_t lane = 0; lane < chains.size(); ++lane) {
      process_noise_[Row(k) + lane] = chains[lane]->process_noise[k];
    }
  }
}

// Lists the views of every frame: each slot in which any chain was measured.
void LaneProblem::LoadViews(const std::vector<const JointChain*>& chains) {
  first_view_.assign(1, 0);
  views_.clear();
  first_place_.clear();
  size_t count = 0;
  for (const JointChain* chain : chains) {
    first_place_.push_back(count);
    count += chain->measurements.size();
  }
  place_.resize(count);
  for (size_t k = 0; k < frames_; ++k) {
    // Sorted by slot, as in each chain alone, so that a joint's sums do not
    // depend on the other lanes.
    slots_.clear();
    for (const JointChain* chain : chains) {
      for (int32_t m = chain->first[k]; m < chain->first[k + 1]; ++m) {
        const PixelMeasurement& measurement = chain->measurements[m];
        const size_t slot = measurement.view_slot;
        if (slot >= slots_.size()) slots_.resize(slot + 1);
        slots_[slot].measurement = &measurement;
      }
    }
    for (Slot& slot : slots_) {
      if (slot.measurement == nullptr) continue;
      slot.view = views_.size();
      views_.push_back(
          {&slot.measurement->camera->model(), slot.measurement->offset_s});
    }
    for (size_t lane = 0; lane < chains.size(); ++lane) {
      const JointChain& chain = *chains[lane];
      for (int32_t m = chain.first[k]; m < chain.first[k + 1]; ++m) {
        const size_t view = slots_[chain.measurements[m].view_slot].view;
        place_[first_place_[lane] + m] = Row(view) + lane;
      }
    }
    first_view_.push_back(static_cast<int>(views_.size()));
  }
}

void LaneProblem::LoadMeasurements(
    const std::vector<const JointChain*>& chains) {
  const size_t size = views_.size() * lanes_;
  for (LaneBuffer* buffer : {&x_px_, &y_px_, &per_sigma_, &information_}) {
    buffer->Assign(size, 0.0);
  }
  counts_.Assign(size, 0.0);
  weights_.Assign(size, 0.0);
  for (size_t lane = 0; lane < chains.size(); ++lane) {
    const std::vector<PixelMeasurement>& measurements =
        chains[lane]->measurements;
    for (size_t m = 0; m < measurements.size(); ++m) {
      const PixelMeasurement& measurement = measurements[m];
      const size_t at = place_[first_place_[lane] + m];
      x_px_[at] = measurement.px.x() - measurement.bias_px.x();
      y_px_[at] = measurement.px.y() - measurement.bias_px.y();
      per_sigma_[at] = 1.0 / measurement.sigma_px;
      information_[at] = measurement.information;
      counts_[at] = measurement.gated ? 0.0 : 1.0;
      weights_[at] = measurement.weight;
    }
  }
}

void LaneProblem::LoadPriors(const std::vector<const JointChain*>& chains) {
  prior_root_.Assign(36 * lanes_, 0.0);
  prior_root_stated_.Assign(36 * lanes_, 0.0);
  prior_x0_.Assign(6 * lanes_, 0.0);
  prior_b_.Assign(6 * lanes_, 0.0);
  for (size_t lane = 0; lane < chains.size(); ++lane) {
    const StatePrior& prior = chains[lane]->prior;
    for (size_t i = 0; i < 36; ++i) {
      prior_root_[Row(i) + lane] = prior.A.data()[i];
      prior_root_stated_[Row(i) + lane] = prior.A_stated.data()[i];
    }
    for (size_t i = 0; i < 6; ++i) {
      prior_x0_[Row(i) + lane] = prior.x0[i];
      prior_b_[Row(i) + lane] = prior.b[i];
    }
  }
  // Keeps lanes without a joint non-singular.
  for (size_t lane = chains.size(); lane < lanes_; ++lane) {
    for (size_t i = 0; i < 6; ++i) {
      prior_root_[Row(7 * i) + lane] = prior_root_stated_[Row(7 * i) + lane] =
          1.0;
    }
  }
}

void LaneProblem::LoadStates(const std::vector<const JointChain*>& chains) {
  states_.Assign(frames_ * 6 * lanes_, 0.0);
  for (size_t lane = 0; lane < chains.size(); ++lane) {
    for (size_t k = 0; k < frames_; ++k) {
      const State& state = chains[lane]->states[k];
      for (size_t i = 0; i < 6; ++i) states_[Row(6 * k + i) + lane] = state[i];
    }
  }
}

void LaneProblem::Load(const PersonProblem& problem,
                       const std::vector<const JointChain*>& chains,
                       size_t lanes) {
  frames_ = problem.times.size();
  lanes_ = lanes;
  LoadTimes(problem, chains);
  LoadViews(chains);
  LoadMeasurements(chains);
  LoadPriors(chains);
  LoadStates(chains);
  arrays_.frames = static_cast<int>(frames_);
  arrays_.joints = static_cast<int>(chains.size());
  arrays_.lanes = static_cast<int>(lanes_);
  arrays_.dt_s = dt_s_.data();
  arrays_.centres = reinterpret_cast<const double(*)[4]>(centres_.data());
  arrays_.process_noise = process_noise_.data();
  arrays_.first_view = first_view_.data();
  arrays_.views = views_.data();
  arrays_.x_px = x_px_.data();
  arrays_.y_px = y_px_.data();
  arrays_.per_sigma = per_sigma_.data();
  arrays_.information = information_.data();
  arrays_.counts = counts_.data();
  arrays_.weights = weights_.data();
  arrays_.prior_A = prior_root_.data();
  arrays_.prior_A_stated = prior_root_stated_.data();
  arrays_.prior_x0 = prior_x0_.data();
  arrays_.prior_b = prior_b_.data();
  arrays_.states = states_.data();
}

StateChain LaneProblem::ChainOf(const LaneBuffer& rows, size_t lane) const {
  StateChain chain(frames_);
  for (size_t k = 0; k < frames_; ++k) {
    for (size_t i = 0; i < 6; ++i) chain[k][i] = rows[Row(6 * k + i) + lane];
  }
  return chain;
}

bool LaneProblem::IsFinite(size_t lane) const {
  for (size_t row = 0; row < 6 * frames_; ++row) {
    if (!std::isfinite(states_[Row(row) + lane])) return false;
  }
  return true;
}

void LaneProblem::Unload(size_t lane, JointChain* chain) const {
  for (size_t k = 0; k < frames_; ++k) {
    for (size_t i = 0; i < 6; ++i) {
      chain->states[k][i] = states_[Row(6 * k + i) + lane];
    }
  }
  for (size_t m = 0; m < chain->measurements.size(); ++m) {
    PixelMeasurement& measurement = chain->measurements[m];
    const size_t at = place_[first_place_[lane] + m];
    measurement.gated = counts_[at] == 0.0;
    measurement.weight = weights_[at];
  }
}

template <typename Chain>
void ChainSolver::Load(const PersonProblem& problem,
                       const std::vector<Chain*>& chains, size_t begin,
                       size_t end) {
  group_.assign(chains.begin() + begin, chains.begin() + end);
  lanes_.Load(problem, group_, kGroup);
  workspace_.Reserve(LaneWorkspaceSize(static_cast<int>(lanes_.frames())));
}

SolveReport ChainSolver::Unload(size_t lane, const SolveSchedule& schedule,
                                JointChain* chain) {
  SolveReport report;
  report.finite = finite_[lane] != 0.0 && lanes_.IsFinite(lane);
  report.converged = converged_[lane] != 0.0;
  report.iterations = static_cast<int>(iterations_[lane]);
  if (!report.finite) {
    for (PixelMeasurement& measurement : chain->measurements) {
      measurement.weight = 0.0;
    }
    return report;
  }
  lanes_.Unload(lane, chain);
  if (!report.converged && schedule.doubt_unsettled) {
    report.unsettled = DoubtUnsettled(lanes_.ChainOf(steps_, lane), chain);
  }
  return report;
}

const std::vector<SolveReport>& ChainSolver::Solve(
    const PersonProblem& problem, const SolveSchedule& schedule,
    const std::vector<JointChain*>& chains) {
  CHECK(!schedule.stages.empty());
  reports_.clear();
  stages_.clear();
  for (size_t i = 0; i < schedule.stages.size(); ++i) {
    const SolveStage& stage = schedule.stages[i];
    stages_.push_back({stage.loss, stage.scale, stage.max_iterations,
                       schedule.StepToleranceM(i)});
  }
  for (size_t at = 0; at < chains.size(); at += kGroup) {
    CheckStop();
    const size_t end = std::min(at + kGroup, chains.size());
    Load(problem, chains, at, end);
    steps_.Reserve(lanes_.Row(6 * lanes_.frames()));
    for (LaneBuffer* buffer : {&finite_, &converged_, &iterations_}) {
      buffer->Reserve(kGroup);
    }
    CurrentLaneKernels().solve(
        lanes_.arrays(), stages_.data(), static_cast<int>(stages_.size()),
        workspace_.data(),
        {finite_.data(), converged_.data(), iterations_.data(), steps_.data()});
    for (size_t i = at; i < end; ++i) {
      reports_.push_back(Unload(i - at, schedule, chains[i]));
    }
  }
  return reports_;
}

std::vector<Matrix6d> ChainSolver::CovariancesIn(size_t lane,
                                                 size_t frame_end) const {
  if (known_[lane] == 0.0) return {};
  std::vector<Matrix6d> covariances(frame_end);
  size_t row = 0;
  for (Matrix6d& covariance : covariances) {
    for (int i = 0; i < 6; ++i) {
      for (int j = i; j < 6; ++j) {
        covariance(i, j) = covariance(j, i) =
            covariances_[lanes_.Row(row++) + lane];
      }
    }
  }
  return covariances;
}

std::vector<std::vector<Matrix6d>> ChainSolver::Covariances(
    const PersonProblem& problem, const std::vector<const JointChain*>& chains,
    double correction, size_t frame_end) {
  std::vector<std::vector<Matrix6d>> covariances;
  for (size_t at = 0; at < chains.size(); at += kGroup) {
    const size_t end = std::min(at + kGroup, chains.size());
    Load(problem, chains, at, end);
    covariances_.Reserve(lanes_.Row(21 * frame_end));
    known_.Reserve(kGroup);
    CurrentLaneKernels().covariance(
        lanes_.arrays(), correction, static_cast<int>(frame_end),
        workspace_.data(), covariances_.data(), known_.data());
    for (size_t i = at; i < end; ++i) {
      covariances.push_back(CovariancesIn(i - at, frame_end));
    }
  }
  return covariances;
}

}  // namespace kinegraph
