#ifndef KINEGRAPH_SOLVERS_CAMERAS_LEFT_OUT_H_
#define KINEGRAPH_SOLVERS_CAMERAS_LEFT_OUT_H_

#include <optional>
#include <vector>

#include "core/geometry/camera.h"
#include "solvers/cameras/bundle.h"
#include "solvers/cameras/camera_change.h"
#include "solvers/cameras/fit_error.h"
#include "solvers/cameras/segments.h"

namespace kinegraph {

// How much a fit of the parameters `free` reduces the error of a view that
// takes no part in it. Each view in turn is left out and keeps its camera of
// `start`; the others are fitted, and the segments that at least two of them
// see are compared with the measurements of the view left out. Cameras that are
// jointly biased by a fit agree better with each other and worse with such a
// view. nullopt with fewer than four views, because the remaining two views of
// three always agree.
std::optional<FitGain> LeftOutGain(const CameraRig& cameras,
                                   const SceneSegments& segments,
                                   const FreeParameters& free,
                                   const std::vector<CameraChange>& start,
                                   const BundleOptions& options);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_CAMERAS_LEFT_OUT_H_
