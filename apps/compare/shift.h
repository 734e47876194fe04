// A constant pixel shift of each camera: what is left when a calibration is
// off.
#ifndef KINEGRAPH_APPS_COMPARE_SHIFT_H_
#define KINEGRAPH_APPS_COMPARE_SHIFT_H_

#include <Eigen/Core>
#include <vector>

#include "core/base/frame_range.h"
#include "solvers/session/run.h"

namespace kinegraph {

// By how much detections lie beside the reprojection [px], one a view: the
// medians, over x and y apart, of detection minus projection of the joints that
// three or more views triangulate, in the frames given. Alternates between
// triangulating with shifted detections and taking medians, until no shift
// moves by 0.01 px or after 50 rounds. What all cameras would explain by moving
// the world is not seen, and does no harm.
std::vector<Eigen::Vector2d> FitShifts(const FrozenRun& run,
                                       const RunOptions& options,
                                       const FrameRange& frames, int threads);

// Detections with the shift of their view taken off.
DetectionSequence Shifted(DetectionSequence detections,
                          const std::vector<Eigen::Vector2d>& shifts_px);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMPARE_SHIFT_H_
