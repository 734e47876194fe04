// Estimates the offsets between the views' clocks in whole frames from people's
// motion: the views agree best when all show the same instant.
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

// The usual step between frame numbers: n if a detector ran on every n-th
// frame; 1 if more than a tenth of the steps are not multiples of their median.
int64_t UsualStep(const std::vector<DetectionFrame>& frames);

// Fills gaps with empty frames at intervals of `step`, so that a lag in frames
// is a lag in time. At either end of a gap it adds at most `longest` of them,
// which suffices for lags of up to `longest` frames, and in total at most ten
// per recorded frame.
DetectionSequence OnGrid(const DetectionSequence& detections, int64_t step,
                         int64_t longest);

// Searches lags of up to `max_lag` frames, but at most a third of the
// recording, whose frames must be evenly spaced (OnGrid). `ideal` holds ideal
// pixels of the cameras (IdealPeople).
ClockSearch SearchClocks(const CameraRig& cameras,
                         const std::vector<ViewPeople>& ideal, int max_lag);

// The detections with each view's frames shifted by its lag, so that each frame
// shows one instant. Frame times are unchanged; a view that lacks the shifted
// frame has no detections.
DetectionSequence Realigned(const DetectionSequence& detections,
                            const std::vector<int>& lag_frames);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SCENE_CLOCK_SEARCH_H_
