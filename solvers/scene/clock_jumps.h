// Pictures that a view lost or has twice: from there on its clock is off by
// whole frames against the other views.
#ifndef KINEGRAPH_SOLVERS_SCENE_CLOCK_JUMPS_H_
#define KINEGRAPH_SOLVERS_SCENE_CLOCK_JUMPS_H_

#include <optional>
#include <vector>

#include "core/data/detection.h"
#include "core/geometry/camera.h"
#include "solvers/scene/camera_change.h"
#include "solvers/scene/segments.h"

namespace kinegraph {

struct ClockJump {
  int view_idx = 0;
  double at_s = 0.0;  // since the middle of the recording
  // Pictures that are missing before `at_s`; negative: that are too many.
  int missing = 0;
  double jump_s = 0.0;   // as measured
  double sigma_s = 0.0;  // its standard deviation
};

// The clearest jump of one view's clock, or nullopt. For each view and short
// bins of time the clock's offset is estimated (steps of Gauss and Newton on
// the stretches, their states eliminated, the other views taken as right); a
// jump is two levels that explain the bins better than offset and drift do,
// nearly whole frames apart.
std::optional<ClockJump> FindClockJump(const CameraRig& cameras,
                                       const SceneSegments& segments,
                                       const std::vector<CameraChange>& changes,
                                       const SegmentOptions& options,
                                       double frame_s);

// The detections with the jump taken back: the view's pictures from index
// `from` on move by what is missing.
DetectionSequence WithoutJump(const DetectionSequence& detections,
                              const ClockJump& jump, int64_t from);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SCENE_CLOCK_JUMPS_H_
