// Whole-frame differences of the views' clocks, from people's motion: the views
// agree best when each shows the same moment.
#ifndef KINEGRAPH_SOLVERS_SCENE_CLOCK_SEARCH_H_
#define KINEGRAPH_SOLVERS_SCENE_CLOCK_SEARCH_H_

#include <cstdint>
#include <vector>

#include "core/data/detection.h"
#include "core/geometry/camera.h"
#include "solvers/scene/view_agreement.h"

namespace kinegraph {

struct ClockSearch {
  // Frame k of the first view was taken at the same time as frame k + lag of
  // view v. All zero without evidence of a lag.
  std::vector<int> lag_frames;
  AgreementGain all;    // over all views
  AgreementGain moved;  // over the pairs whose lags differ
  bool found() const;
};

// Lags up to `max_lag` frames and a third of the recording. `ideal` holds ideal
// pixels of the cameras.
ClockSearch SearchClocks(const CameraRig& cameras,
                         const std::vector<ViewPeople>& ideal, int max_lag);

// The detections with each view's frames shifted by its lag, so that a frame
// shows one moment. Times stay those of the frames; where a view lacks the
// frame, it has no detections.
DetectionSequence Realigned(const DetectionSequence& detections,
                            const std::vector<int>& lag_frames);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SCENE_CLOCK_SEARCH_H_
