// Compiled for AVX2; empty on other architectures.
#if defined(__x86_64__)
#ifndef __AVX2__
#error "not compiled for AVX2: see kinegraph_lanes in KinegraphTargets.cmake"
#endif

#include "core/base/dense_kernel.h"

namespace kinegraph {

bool EliminateDenseAvx2(const DenseElimination& blocks) {
  return EliminateDenseWith<Avx2Pack>(blocks);
}

}  // namespace kinegraph

#endif
