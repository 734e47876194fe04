// chain_lanes.h by instruction set, for its dispatch alone.
#ifndef KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_CHAIN_LANES_WIDE_H_
#define KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_CHAIN_LANES_WIDE_H_

#include "solvers/block_tridiagonal/chain_lanes.h"

namespace kinegraph {

// The functions of chain_lanes.h, compiled for one instruction set.
struct LaneKernels {
  decltype(&SolveChainLanes) solve;
  decltype(&CovarianceChainLanes) covariance;
  decltype(&LineariseChainLanes) linearise;
  decltype(&WeighChainLanes) weigh;
  decltype(&SolveCoupledLanes) solve_coupled;
};

extern const LaneKernels kLaneKernelsAvx2;
extern const LaneKernels kLaneKernelsAvx512;

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_CHAIN_LANES_WIDE_H_
