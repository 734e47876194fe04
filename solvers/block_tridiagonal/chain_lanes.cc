#include "solvers/block_tridiagonal/chain_lanes.h"

#include "core/base/instruction_set.h"
#include "solvers/block_tridiagonal/chain_kernel.h"
#include "solvers/block_tridiagonal/chain_lanes_wide.h"
#include "solvers/block_tridiagonal/coupled_kernel.h"

namespace kinegraph {
namespace {

const LaneKernels kBaseline = {
    SolveChainLanesWith<BaselinePack>, CovarianceChainLanesWith<BaselinePack>,
    LineariseChainLanesWith<BaselinePack>, WeighChainLanesWith<BaselinePack>,
    SolveCoupledLanesWith<BaselinePack>};

const LaneKernels& Kernels() {
  switch (CurrentInstructionSet()) {
#if defined(__x86_64__)
    case InstructionSet::kAvx512:
      return kLaneKernelsAvx512;
    case InstructionSet::kAvx2:
      return kLaneKernelsAvx2;
#endif
    default:
      return kBaseline;
  }
}

}  // namespace

long LaneWorkspaceSize(int frames) {
  return frames * ChainGroup<BaselinePack>::kNumbersPerFrame * kLaneMultiple;
}

long CoupledWorkspaceSize(int frames, int lanes) {
  // Beside the frames' rows those of the first states and of sums.
  return (frames * CoupledSolve<BaselinePack>::kRowsPerFrame + 7) * lanes;
}

void SolveChainLanes(const ChainLanes& chains, const LaneStage* stages,
                     int stage_count, double step_tolerance_m,
                     double* workspace, const LaneReports& reports) {
  Kernels().solve(chains, stages, stage_count, step_tolerance_m, workspace,
                  reports);
}

void CovarianceChainLanes(const ChainLanes& chains, double correction,
                          int frame_end, double* workspace, double* covariances,
                          double* known) {
  Kernels().covariance(chains, correction, frame_end, workspace, covariances,
                       known);
}

void LineariseChainLanes(const ChainLanes& chains, const LaneStage& stage,
                         bool own_priors, double* workspace,
                         const LaneSystemRows& system) {
  Kernels().linearise(chains, stage, own_priors, workspace, system);
}

void WeighChainLanes(const ChainLanes& chains, const LaneStage& stage,
                     double* workspace) {
  Kernels().weigh(chains, stage, workspace);
}

bool SolveCoupledLanes(const ChainLanes& chains, const LaneSystemRows& system,
                       const LaneCouplings& couplings, double damping,
                       double accuracy, double* workspace, double* step) {
  return Kernels().solve_coupled(chains, system, couplings, damping, accuracy,
                                 workspace, step);
}

}  // namespace kinegraph
