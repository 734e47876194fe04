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
// takes no part in it. Each view in turn is left out with its camera unchanged,
// the others are fitted, and its error is measured at the points that at least
// two of them see. Cameras that are jointly biased by a fit agree better with
// each other and worse with a held-out camera. nullopt with fewer than four
// views: of three, two would remain to be fitted, which always agree.
std::optional<FitGain> LeftOutGain(const CameraRig& cameras,
                                   const SceneSegments& segments,
                                   const FreeParameters& free,
                                   const std::vector<CameraChange>& start,
                                   const BundleOptions& options);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_CAMERAS_LEFT_OUT_H_
