#include "solvers/block_tridiagonal/chain_lanes.h"

#include "core/base/instruction_set.h"
#include "solvers/block_tridiagonal/coupled_kernel.h"

namespace kinegraph {

const LaneKernels& CurrentLaneKernels() {
  static constexpr LaneKernels kBaseline = LaneKernelsOf<BaselinePack>();
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

long LaneWorkspaceSize(int frames) {
  return frames * ChainGroup<BaselinePack>::kNumbersPerFrame * kLaneMultiple;
}

long CoupledWorkspaceSize(int frames, int lanes) {
  // Besides the rows of the frames: six for the first states, one for sums.
  return (frames * CoupledSolve<BaselinePack>::kRowsPerFrame + 7) * lanes;
}

}  // namespace kinegraph
