// Which way is up in the world of some tracks: one answer, which may be "not
// known", from how people stand, the floor that they share, what a file states
// and how the cameras are held.
#ifndef KINEGRAPH_CORE_DATA_STANCE_H_
#define KINEGRAPH_CORE_DATA_STANCE_H_

#include <Eigen/Core>
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

// What is known of up beside the people.
struct UpEvidence {
  // A unit vector: the vertical axis of a file whose format has one.
  std::optional<Eigen::Vector3d> stated;
  Eigen::Vector3d of_cameras = Eigen::Vector3d::Zero();  // UpOfCameras
};

// Looks at poses of a skeleton under our names.
class Stance {
 public:
  explicit Stance(const Skeleton& skeleton) : skeleton_(skeleton) {}
  void See(const PersonPose& person);

  // The unit vector that points up; nullopt where it is not known. In this
  // order: the direction along which people stand whose lowest joints share a
  // floor while in others they do not; the stated axis, unless people stand
  // across it who cannot be lying; the direction along which people stand,
  // unless they may lie. Who has both hands above the head may stand on them
  // and does not count.
  std::optional<Eigen::Vector3d> Up(const UpEvidence& known = {}) const;

  // The same where people were seen and it is more than 50 degrees off `up`, a
  // unit vector.
  std::optional<Eigen::Vector3d> UpUnlike(const Eigen::Vector3d& up,
                                          const UpEvidence& known = {}) const;

 private:
  struct Body {
    Eigen::Vector3d up;  // unit: from ankles to shoulders; who sits: the trunk
    bool is_straight = false;
    std::vector<Eigen::Vector3d> joints_m;

    // Least and largest coordinate along a direction [m].
    double Low(const Eigen::Vector3d& along) const;
    double High(const Eigen::Vector3d& along) const;
  };
  // Bodies that point one way.
  struct Group {
    Eigen::Vector3d up = Eigen::Vector3d::Zero();  // unit: their mean
    double share = 0.0;                            // of all bodies
    double straight = 0.0;                         // share of its own
  };

  std::vector<Group> Groups() const;
  double FloorSpread(const Eigen::Vector3d& up) const;
  std::optional<Eigen::Vector3d> ByFloor(
      const std::vector<Group>& groups,
      const std::vector<Eigen::Vector3d>& others) const;
  bool MayLie(const Eigen::Vector3d& up) const;

  Skeleton skeleton_;
  std::vector<Body> bodies_;  // evenly among those seen
  int64_t seen_ = 0;
  int64_t stride_ = 1;  // every so many-th is kept
};

Stance StanceOf(const Skeleton& skeleton,
                const std::vector<TrackFrame>& frames);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_DATA_STANCE_H_
