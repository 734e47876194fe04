// Compiled for AVX2; empty on other machines.
#if defined(__x86_64__)
#ifndef __AVX2__
#error "not compiled for it: kinegraph_lanes in cmake/KinegraphTargets.cmake"
#endif

#include "solvers/block_tridiagonal/chain_kernel.h"
#include "solvers/block_tridiagonal/chain_lanes_wide.h"
#include "solvers/block_tridiagonal/coupled_kernel.h"

namespace kinegraph {

const LaneKernels kLaneKernelsAvx2 = {
    SolveChainLanesWith<Avx2Pack>, CovarianceChainLanesWith<Avx2Pack>,
    LineariseChainLanesWith<Avx2Pack>, WeighChainLanesWith<Avx2Pack>,
    SolveCoupledLanesWith<Avx2Pack>};

}  // namespace kinegraph

#endif
