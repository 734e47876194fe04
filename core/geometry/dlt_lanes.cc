#include "core/geometry/dlt_lanes.h"

#include "core/base/instruction_set.h"
#include "core/geometry/dlt_kernel.h"

namespace kinegraph {

void TriangulateLanes(const LaneView* views, int view_count, int lanes,
                      const TriangulationOptions& options,
                      const LanePoints& points) {
  switch (CurrentInstructionSet()) {
#if defined(__x86_64__)
    case InstructionSet::kAvx512:
      return TriangulateLanesAvx512(views, view_count, lanes, options, points);
    case InstructionSet::kAvx2:
      return TriangulateLanesAvx2(views, view_count, lanes, options, points);
#endif
    default:
      return TriangulateLanesWith<BaselinePack>(views, view_count, lanes,
                                                options, points);
  }
}

void MarkConflicts(const LaneView& a, const LaneView& b,
                   const double* fundamental, double alpha_px, int lanes,
                   double* conflict) {
  switch (CurrentInstructionSet()) {
#if defined(__x86_64__)
    case InstructionSet::kAvx512:
      return MarkConflictsAvx512(a, b, fundamental, alpha_px, lanes, conflict);
    case InstructionSet::kAvx2:
      return MarkConflictsAvx2(a, b, fundamental, alpha_px, lanes, conflict);
#endif
    default:
      return MarkConflictsWith<BaselinePack>(a, b, fundamental, alpha_px, lanes,
                                             conflict);
  }
}

}  // namespace kinegraph
