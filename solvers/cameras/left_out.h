// Whether other cameras explain a view that took no part in finding them.
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

// What a fit of some parameters gives in a view that took no part in it and
// stays as it starts: each view in turn, at points that two others or more
// place. Cameras that are bent together agree better with each other and worse
// with one that was left out. nullopt with fewer than four views: of three, two
// would be left, which explain each other whatever they are.
std::optional<FitGain> LeftOutGain(const CameraRig& cameras,
                                   const SceneSegments& segments,
                                   const FreeParameters& free,
                                   const std::vector<CameraChange>& start,
                                   const BundleOptions& options);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_CAMERAS_LEFT_OUT_H_
