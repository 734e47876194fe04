// dlt_lanes.h by instruction set, for its dispatch alone.
#ifndef KINEGRAPH_CORE_GEOMETRY_DLT_LANES_WIDE_H_
#define KINEGRAPH_CORE_GEOMETRY_DLT_LANES_WIDE_H_

#include "core/geometry/dlt_lanes.h"

namespace kinegraph {

#define KINEGRAPH_DLT_LANES(Set)                                               \
  void TriangulateLanes##Set(const LaneView* views, int view_count, int lanes, \
                             const DltLanesOptions& options,                   \
                             const LanePoints& points);                        \
  void MarkConflicts##Set(const LaneView& a, const LaneView& b,                \
                          const double* fundamental, double alpha_px,          \
                          int lanes, double* conflict);
KINEGRAPH_DLT_LANES(Avx2)
KINEGRAPH_DLT_LANES(Avx512)
#undef KINEGRAPH_DLT_LANES

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_GEOMETRY_DLT_LANES_WIDE_H_
