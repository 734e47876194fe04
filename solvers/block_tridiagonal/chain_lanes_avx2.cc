// Compiled for AVX2; empty on other architectures.
#if defined(__x86_64__)
#ifndef __AVX2__
#error "needs AVX2, see kinegraph_lanes in cmake/KinegraphTargets.cmake"
#endif

#include "solvers/block_tridiagonal/coupled_kernel.h"

namespace kinegraph {

const LaneKernels kLaneKernelsAvx2 = LaneKernelsOf<Avx2Pack>();

}  // namespace kinegraph

#endif
