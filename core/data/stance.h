// How people stand in the world of their tracks: which way is up by their
// bodies.
#ifndef KINEGRAPH_CORE_DATA_STANCE_H_
#define KINEGRAPH_CORE_DATA_STANCE_H_

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/data/pose.h"
#include "core/geometry/camera.h"

namespace kinegraph {

// Mean way up of the cameras' images, not of unit length; zero without cameras.
Eigen::Vector3d UpOfCameras(const CameraRig& cameras);

// The world axis, with its sign, that a direction is within so many degrees of;
// nullopt when there is none.
std::optional<Eigen::Vector3d> NearestAxis(const Eigen::Vector3d& direction,
                                           double within_deg);

// Looks at poses of a skeleton under our names.
class Stance {
 public:
  explicit Stance(const Skeleton& skeleton) : skeleton_(skeleton) {}
  void See(const PersonPose& person);

  // Sum of the ways from ankles to shoulders [m] over all poses that have both;
  // zero when none has.
  const Eigen::Vector3d& body_sum_m() const { return body_sum_m_; }

  // The unit vector along which people stand; nullopt where too few do or they
  // do not agree. Who has both hands above the head may stand on them and does
  // not count.
  std::optional<Eigen::Vector3d> Up() const;

  // The same where it is more than 50 degrees off `up`, a world axis with its
  // sign, and cannot mean that people lie: the cameras agree, or, without
  // cameras, people do not keep to one height between the floor, where that is
  // zero, and a bed.
  std::optional<Eigen::Vector3d> UpUnlike(const Eigen::Vector3d& up,
                                          const CameraRig& cameras = {}) const;

 private:
  // Least and largest coordinates of a pose [m].
  struct Extent {
    std::array<double, 3> low_m;
    std::array<double, 3> high_m;
  };

  bool MayLie(const Eigen::Vector3d& up) const;

  Skeleton skeleton_;
  Eigen::Vector3d body_sum_m_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction_sum_ = Eigen::Vector3d::Zero();
  std::vector<Extent> extents_;  // of those in direction_sum_
};

Stance StanceOf(const Skeleton& skeleton,
                const std::vector<TrackFrame>& frames);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_DATA_STANCE_H_
