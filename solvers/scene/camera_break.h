// A camera that was moved in the middle of a recording: from some frame on its
// view no longer agrees with the others as it did.
#ifndef KINEGRAPH_SOLVERS_SCENE_CAMERA_BREAK_H_
#define KINEGRAPH_SOLVERS_SCENE_CAMERA_BREAK_H_

#include <cstddef>
#include <optional>
#include <vector>

#include "core/data/detection.h"
#include "core/geometry/camera.h"
#include "solvers/scene/view_agreement.h"

namespace kinegraph {

struct CameraBreak {
  size_t view = 0;
  size_t from = 0;  // index of the first frame behind it
  // Agreement with the other views (PairAgreement) on either side, less that of
  // the other views among themselves.
  double before = 0.0;
  double after = 0.0;

  bool worse_after() const { return after < before; }
};

// The clearest break, or nullopt: two levels of one view's agreement, frame by
// frame and without tracking. With fewer than three views nobody can say whose
// it is. `ideal` holds ideal pixels, one a camera; times of its frames in
// `detections`. A lost picture looks alike; the caller tells them apart.
std::optional<CameraBreak> FindCameraBreak(const CameraRig& cameras,
                                           const std::vector<ViewPeople>& ideal,
                                           const DetectionSequence& detections);

// The frames before `from` (side 0) or from it on (side 1).
DetectionSequence SideOf(const DetectionSequence& detections, size_t from,
                         int side);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SCENE_CAMERA_BREAK_H_
