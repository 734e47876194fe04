#include "solvers/sweeps/chain_lanes.h"

#include "core/base/instruction_set.h"
#include "solvers/sweeps/chain_kernel.h"
#include "solvers/sweeps/chain_lanes_wide.h"

namespace kinegraph {

long LaneWorkspaceSize(int frames) {
  return frames * ChainGroup<BaselinePack>::kNumbersPerFrame * kLaneMultiple;
}

void SolveChainLanes(const ChainLanes& chains, const LaneStage* stages,
                     int stage_count, double step_tolerance_m,
                     double* workspace, const LaneReports& reports) {
  switch (CurrentInstructionSet()) {
#if defined(__x86_64__)
    case InstructionSet::kAvx512:
      return SolveChainLanesAvx512(chains, stages, stage_count,
                                   step_tolerance_m, workspace, reports);
    case InstructionSet::kAvx2:
      return SolveChainLanesAvx2(chains, stages, stage_count, step_tolerance_m,
                                 workspace, reports);
#endif
    default:
      return SolveChainLanesWith<BaselinePack>(
          chains, stages, stage_count, step_tolerance_m, workspace, reports);
  }
}

void CovarianceChainLanes(const ChainLanes& chains, double correction,
                          int frame_end, double* workspace, double* covariances,
                          double* known) {
  switch (CurrentInstructionSet()) {
#if defined(__x86_64__)
    case InstructionSet::kAvx512:
      return CovarianceChainLanesAvx512(chains, correction, frame_end,
                                        workspace, covariances, known);
    case InstructionSet::kAvx2:
      return CovarianceChainLanesAvx2(chains, correction, frame_end, workspace,
                                      covariances, known);
#endif
    default:
      return CovarianceChainLanesWith<BaselinePack>(
          chains, correction, frame_end, workspace, covariances, known);
  }
}

}  // namespace kinegraph
