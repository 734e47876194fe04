// Compiled for AVX-512; empty on architectures other than x86-64.
#if defined(__x86_64__)
#ifndef __AVX512F__
#error "not compiled for AVX-512: see kinegraph_lanes in KinegraphTargets.cmake"
#endif

#include "core/geometry/dlt_kernel.h"

namespace kinegraph {

void TriangulateLanesAvx512(const LaneView* views, int view_count, int lanes,
                            const TriangulationOptions& options,
                            const LanePoints& points) {
  TriangulateLanesWith<Avx512Pack>(views, view_count, lanes, options, points);
}

void MarkConflictsAvx512(const LaneView& a, const LaneView& b,
                         const double* fundamental, double alpha_px, int lanes,
                         double* conflict) {
  MarkConflictsWith<Avx512Pack>(a, b, fundamental, alpha_px, lanes, conflict);
}

}  // namespace kinegraph

#endif
