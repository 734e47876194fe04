// Compiled for AVX-512; empty on other machines.
#if defined(__x86_64__)

#include "solvers/sweeps/chain_kernel.h"
#include "solvers/sweeps/chain_lanes_wide.h"

namespace kinegraph {

void SolveChainLanesAvx512(const ChainLanes& chains, const LaneStage* stages,
                           int stage_count, double step_tolerance_m,
                           double* workspace, const LaneReports& reports) {
  SolveChainLanesWith<Avx512Pack>(chains, stages, stage_count, step_tolerance_m,
                                  workspace, reports);
}

void CovarianceChainLanesAvx512(const ChainLanes& chains, double correction,
                                int frame_end, double* workspace,
                                double* covariances, double* known) {
  CovarianceChainLanesWith<Avx512Pack>(chains, correction, frame_end, workspace,
                                       covariances, known);
}

}  // namespace kinegraph

#endif
