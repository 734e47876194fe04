// Estimates the upward direction of tracks from the directions in which people
// stand, the floor they share, the file's stated axis and the orientation of
// the cameras.
#ifndef KINEGRAPH_CORE_DATA_STANCE_H_
#define KINEGRAPH_CORE_DATA_STANCE_H_

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/data/pose.h"
#include "core/geometry/camera.h"

namespace kinegraph {

// Mean upward direction of the cameras' images, not normalised; zero without
// cameras.
Eigen::Vector3d UpOfCameras(const CameraRig& cameras);

// The signed world axis within this angle of a direction; nullopt if there is
// none.
std::optional<Eigen::Vector3d> NearestAxis(const Eigen::Vector3d& direction,
                                           double within_deg);

// Evidence on the vertical besides the people.
struct UpEvidence {
  // A unit vector: the vertical axis of a file whose format has one.
  std::optional<Eigen::Vector3d> stated;
  Eigen::Vector3d of_cameras = Eigen::Vector3d::Zero();  // UpOfCameras
};

// Collects poses of a skeleton with kinegraph's joint names ("l_hip").
class Stance {
 public:
  explicit Stance(const Skeleton& skeleton) : skeleton_(skeleton) {}
  // Adds a pose.
  void See(const PersonPose& person);

  // The unit vector that points up; nullopt if unknown. The cameras' upward
  // direction is that of UpOfCameras or, if there is one, the world axis within
  // 40 degrees of it. The first that applies:
  // - among the directions in which people stand, the stated axis and the
  //   cameras' upward direction: the one along which people's lowest joints are
  //   at one height, if they are not along the others;
  // - the stated axis or, without one, the cameras' upward direction, if there
  //   are no people or fewer than 80 % of them stand in one direction;
  // - the stated axis, unless people stand at more than 50 degrees to it and
  //   cannot be lying;
  // - the direction in which people stand or, unless most of them are straight,
  //   the world axis within 40 degrees of it (unknown if there is none);
  //   unknown also if people stand at more than 50 degrees to the cameras'
  //   upward direction or, without cameras, may be lying in a world with z up.
  // A person whose hands are clearly above the shoulders may be doing a
  // handstand and is ignored.
  std::optional<Eigen::Vector3d> Up(const UpEvidence& known = {}) const;

  // Up(known), if there are people and the result differs from `up`, a unit
  // vector, by more than 50 degrees; otherwise nullopt.
  std::optional<Eigen::Vector3d> UpUnlike(const Eigen::Vector3d& up,
                                          const UpEvidence& known = {}) const;

 private:
  struct Body {
    // Unit vector: from ankles (else hips) to shoulders; for a bent body the
    // mean of this direction and that of the trunk.
    Eigen::Vector3d up;
    bool is_straight = false;
    std::vector<Eigen::Vector3d> joints_m;

    // Least and greatest coordinate along a direction [m].
    double Low(const Eigen::Vector3d& along) const;
    double High(const Eigen::Vector3d& along) const;
  };
  // Bodies with a common upward direction.
  struct Group {
    Eigen::Vector3d up = Eigen::Vector3d::Zero();  // unit: their mean
    double share = 0.0;                            // of all bodies
    double straight = 0.0;  // share of the group's bodies that are straight
  };

  std::vector<Group> Groups() const;
  // Spread of the heights of the bodies' lowest joints [m].
  double FloorSpread(const Eigen::Vector3d& up) const;
  // The candidate (groups and `others`) along which FloorSpread is small and by
  // far the least; nullopt if there is none.
  std::optional<Eigen::Vector3d> ByFloor(
      const std::vector<Group>& groups,
      const std::vector<Eigen::Vector3d>& others) const;
  // Whether most bodies may be lying still on the floor or a bed.
  bool MayLie(const Eigen::Vector3d& up) const;

  Skeleton skeleton_;
  std::vector<Body> bodies_;  // evenly spaced among all
  int64_t seen_ = 0;
  int64_t stride_ = 1;  // one in `stride_` is kept
};

Stance StanceOf(const Skeleton& skeleton,
                const std::vector<TrackFrame>& frames);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_DATA_STANCE_H_
