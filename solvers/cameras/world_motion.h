#ifndef KINEGRAPH_SOLVERS_CAMERAS_WORLD_MOTION_H_
#define KINEGRAPH_SOLVERS_CAMERAS_WORLD_MOTION_H_

#include <optional>

#include "core/geometry/camera.h"

namespace kinegraph {

// How far the world moved, from sampled points in the world of the old cameras
// and the points that the new cameras see at the same pixels.
struct WorldMotion {
  double moved_m = 0.0;  // mean displacement of the points
  // Rotation and scale of the similarity transformation fitted to the points.
  double turned_deg = 0.0;
  double scale = 1.0;  // of lengths
};

// Evaluated at those of 27 grid points of a cube that at least two cameras see.
// The cube's centre is the point nearest to all optical axes, its half edge a
// quarter of the distance to the nearest camera. `after`: the cameras of
// `before` after refinement, in the same order. nullopt if the axes are nearly
// parallel or fewer than nine points are seen.
std::optional<WorldMotion> WorldMotionOf(const CameraRig& before,
                                         const CameraRig& after);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_CAMERAS_WORLD_MOTION_H_
