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

// Gain of a fit of some parameters in a view that is excluded from it and keeps
// its camera: each view in turn, at points that at least two others
// triangulate. Cameras that are jointly biased by a fit agree better with each
// other and worse with a held-out camera. nullopt with fewer than four views,
// because the remaining two views of three always agree.
std::optional<FitGain> LeftOutGain(const CameraRig& cameras,
                                   const SceneSegments& segments,
                                   const FreeParameters& free,
                                   const std::vector<CameraChange>& start,
                                   const BundleOptions& options);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_CAMERAS_LEFT_OUT_H_
