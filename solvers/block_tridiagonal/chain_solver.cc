#include "solvers/block_tridiagonal/chain_solver.h"

#include <glog/logging.h>

#include <algorithm>

#include "core/base/stop_check.h"

namespace kinegraph {

void ChainSolver::Load(const std::vector<TimeNs>& times,
                       const std::vector<const JointChain*>& chains) {
  lanes_.Load(times, chains, kGroup);
  workspace_.Reserve(LaneWorkspaceSize(static_cast<int>(times.size())));
}

SolveReport ChainSolver::Unload(size_t lane, const SolveSchedule& schedule,
                                JointChain* chain) {
  SolveReport report;
  report.finite = finite_[lane] != 0.0;
  report.converged = converged_[lane] != 0.0;
  report.iterations = static_cast<int>(iterations_[lane]);
  lanes_.UnloadStates(lane, chain);
  lanes_.UnloadWeights(lane, chain);
  if (!report.finite) {
    for (PixelMeasurement& measurement : chain->measurements) {
      measurement.weight = 0.0;
    }
  }
  if (!report.finite || report.converged || !schedule.doubt_unsettled) {
    return report;
  }
  step_.resize(lanes_.frames());
  for (size_t k = 0; k < lanes_.frames(); ++k) {
    for (size_t i = 0; i < 6; ++i) {
      step_[k][i] = steps_[lanes_.Row(6 * k + i) + lane];
    }
  }
  report.unsettled = DoubtUnsettled(step_, chain);
  return report;
}

void ChainSolver::SolveGroup(const std::vector<TimeNs>& times,
                             const SolveSchedule& schedule,
                             const std::vector<JointChain*>& chains,
                             std::vector<SolveReport>* reports) {
  Load(times, {chains.begin(), chains.end()});
  steps_.Reserve(lanes_.Row(6 * times.size()));
  for (LaneBuffer* buffer : {&finite_, &converged_, &iterations_}) {
    buffer->Reserve(kGroup);
  }
  std::vector<LaneStage> stages;
  for (const SolveStage& stage : schedule.stages) {
    stages.push_back({stage.loss, stage.scale, stage.max_iterations});
  }
  CurrentLaneKernels().solve(
      lanes_.arrays(), stages.data(), static_cast<int>(stages.size()),
      schedule.step_tolerance_m, workspace_.data(),
      {finite_.data(), converged_.data(), iterations_.data(), steps_.data()});
  for (size_t lane = 0; lane < chains.size(); ++lane) {
    reports->push_back(Unload(lane, schedule, chains[lane]));
  }
}

std::vector<SolveReport> ChainSolver::Solve(
    const std::vector<TimeNs>& times, const SolveSchedule& schedule,
    const std::vector<JointChain*>& chains) {
  CHECK(!schedule.stages.empty());
  if (times.empty()) return std::vector<SolveReport>(chains.size());
  std::vector<SolveReport> reports;
  for (size_t at = 0; at < chains.size(); at += kGroup) {
    CheckStop();
    const size_t end = std::min(at + kGroup, chains.size());
    SolveGroup(times, schedule, {chains.begin() + at, chains.begin() + end},
               &reports);
  }
  return reports;
}

void ChainSolver::CovariancesOfGroup(
    const std::vector<TimeNs>& times,
    const std::vector<const JointChain*>& chains, double correction,
    size_t frame_end, std::vector<std::vector<Matrix6d>>* covariances) {
  Load(times, chains);
  covariances_.Reserve(lanes_.Row(21 * frame_end));
  known_.Reserve(kGroup);
  CurrentLaneKernels().covariance(
      lanes_.arrays(), correction, static_cast<int>(frame_end),
      workspace_.data(), covariances_.data(), known_.data());
  for (size_t lane = 0; lane < chains.size(); ++lane) {
    covariances->emplace_back();
    if (known_[lane] == 0.0) continue;
    covariances->back().resize(frame_end);
    for (size_t k = 0; k < frame_end; ++k) {
      size_t row = 21 * k;
      Matrix6d& covariance = covariances->back()[k];
      for (int i = 0; i < 6; ++i) {
        for (int j = i; j < 6; ++j) {
          covariance(i, j) = covariance(j, i) =
              covariances_[lanes_.Row(row++) + lane];
        }
      }
    }
  }
}

std::vector<std::vector<Matrix6d>> ChainSolver::Covariances(
    const std::vector<TimeNs>& times,
    const std::vector<const JointChain*>& chains, double correction,
    size_t frame_end) {
  if (times.empty()) return std::vector<std::vector<Matrix6d>>(chains.size());
  std::vector<std::vector<Matrix6d>> covariances;
  for (size_t at = 0; at < chains.size(); at += kGroup) {
    const size_t end = std::min(at + kGroup, chains.size());
    CovariancesOfGroup(times, {chains.begin() + at, chains.begin() + end},
                       correction, std::min(frame_end, times.size()),
                       &covariances);
  }
  return covariances;
}

}  // namespace kinegraph
