// Compiled for AVX-512; empty on other architectures.
#if defined(__x86_64__)
#ifndef __AVX512F__
#error "not compiled for AVX-512: see kinegraph_lanes in KinegraphTargets.cmake"
#endif

#include "core/base/dense_kernel.h"

namespace kinegraph {

bool EliminateDenseAvx512(const DenseElimination& blocks) {
  return EliminateDenseWith<Avx512Pack>(blocks);
}

}  // namespace kinegraph

#endif
