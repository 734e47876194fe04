// What cameras could see of a scene at one moment, before any fault.
#ifndef KINEGRAPH_CORE_SYNTHETIC_SIGHT_H_
#define KINEGRAPH_CORE_SYNTHETIC_SIGHT_H_

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/base/time.h"
#include "core/data/pose.h"
#include "core/geometry/camera.h"
#include "core/synthetic/body.h"
#include "core/synthetic/occlusion.h"
#include "core/synthetic/scene.h"

namespace kinegraph {

// The scene at one moment.
struct SceneMoment {
  TimeNs time = 0;
  std::vector<Pose3d> poses;        // by person; empty: not there
  std::vector<SegmentPose> trunks;  // meaningless where not there
  std::vector<std::optional<Obstacle>> obstacles;  // empty: do not matter
};

SceneMoment LookAtScene(const Scene& scene, TimeNs time, bool with_obstacles);

// What the camera could see of one joint.
struct JointSight {
  bool in_image = false;
  bool hidden = false;                           // by another body
  Eigen::Vector2d px = Eigen::Vector2d::Zero();  // exact
  double depth_m = 1.0;
};

// Of one person in one frame.
struct PersonSight {
  bool present = false;      // in the scene
  double azimuth_deg = 0.0;  // of the camera, 0 in front, +90 to the right
  std::vector<JointSight> joints;
};

// The image's size decides where wrong joints can lie.
struct ImageBounds {
  double width_px = 0.0;
  double height_px = 0.0;

  bool Contains(const Eigen::Vector2d& px) const {
    return px.x() >= 0.0 && px.y() >= 0.0 && px.x() < width_px &&
           px.y() < height_px;
  }
};

inline ImageBounds SizeOf(const Camera& camera) {
  return {static_cast<double>(camera.width_px()),
          static_cast<double>(camera.height_px())};
}

// One entry a person.
std::vector<PersonSight> Sights(const Camera& camera, const SceneMoment& moment,
                                int joint_count);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_SYNTHETIC_SIGHT_H_
