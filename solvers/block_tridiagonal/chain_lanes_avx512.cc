// Compiled for AVX-512; empty on other architectures.
#if defined(__x86_64__)
#ifndef __AVX512F__
#error "needs AVX-512, see kinegraph_lanes in cmake/KinegraphTargets.cmake"
#endif

#include "solvers/block_tridiagonal/coupled_kernel.h"

namespace kinegraph {

const LaneKernels kLaneKernelsAvx512 = LaneKernelsOf<Avx512Pack>();

}  // namespace kinegraph

#endif
