// chain_lanes.h by instruction set, for its dispatch alone.
#ifndef KINEGRAPH_SOLVERS_SWEEPS_CHAIN_LANES_WIDE_H_
#define KINEGRAPH_SOLVERS_SWEEPS_CHAIN_LANES_WIDE_H_

#include "solvers/sweeps/chain_lanes.h"

namespace kinegraph {

#define KINEGRAPH_CHAIN_LANES(Set)                                             \
  void SolveChainLanes##Set(const ChainLanes& chains, const LaneStage* stages, \
                            int stage_count, double step_tolerance_m,          \
                            double* workspace, const LaneReports& reports);    \
  void CovarianceChainLanes##Set(const ChainLanes& chains, double correction,  \
                                 int frame_end, double* workspace,             \
                                 double* covariances, double* known);
KINEGRAPH_CHAIN_LANES(Avx2)
KINEGRAPH_CHAIN_LANES(Avx512)
#undef KINEGRAPH_CHAIN_LANES

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SWEEPS_CHAIN_LANES_WIDE_H_
