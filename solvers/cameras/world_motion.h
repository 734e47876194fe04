// How refined cameras move the world that they see.
#ifndef KINEGRAPH_SOLVERS_CAMERAS_WORLD_MOTION_H_
#define KINEGRAPH_SOLVERS_CAMERAS_WORLD_MOTION_H_

#include <optional>

#include "core/geometry/camera.h"

namespace kinegraph {

// The similarity that takes points where the old cameras see them to where the
// new ones see the same pixels.
struct WorldMotion {
  double moved_m = 0.0;  // mean distance of the points
  double turned_deg = 0.0;
  double scale = 1.0;  // of lengths
};

// Over the part that two or more cameras see of a cube around the point nearest
// to all optical axes, whose half edge is a quarter of the distance to the
// nearest camera. `after` are the cameras of `before`, in the same order.
// nullopt where the axes are parallel or too little is seen.
std::optional<WorldMotion> WorldMotionOf(const CameraRig& before,
                                         const CameraRig& after);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_CAMERAS_WORLD_MOTION_H_
