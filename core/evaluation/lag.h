// Delay of a motion behind a reference.
#ifndef KINEGRAPH_CORE_EVALUATION_LAG_H_
#define KINEGRAPH_CORE_EVALUATION_LAG_H_

#include <optional>
#include <vector>

#include "core/base/frame_range.h"
#include "core/data/pose.h"

namespace kinegraph {

struct LagOptions {
  double max_lag_s = 0.4;          // in both directions
  std::vector<FrameRange> frames;  // of the reference; none: all
};

// The delay of `tracks` behind `reference` [s] that maximises the
// cross-correlation of their velocities (Knapp and Carter 1976, without
// weighting), all common body joints and axes together; a parabola through the
// greatest value and its neighbours gives fractions of a frame. People are
// paired frame by frame within 0.5 m. Negative: too early. nullopt when too
// little of the two overlaps or nobody moves.
std::optional<double> EstimateLag(const TrackSequence& reference,
                                  const TrackSequence& tracks, double rate_hz,
                                  const LagOptions& options = {});

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_LAG_H_
