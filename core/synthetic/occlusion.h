// Which points other people's bodies hide.
#ifndef KINEGRAPH_CORE_SYNTHETIC_OCCLUSION_H_
#define KINEGRAPH_CORE_SYNTHETIC_OCCLUSION_H_

#include <Eigen/Core>
#include <vector>

#include "core/synthetic/body.h"

namespace kinegraph {

// Squared distance between the segments [p0, p1] and [q0, q1].
double SquaredSegmentDistance(const Eigen::Vector3d& p0,
                              const Eigen::Vector3d& p1,
                              const Eigen::Vector3d& q0,
                              const Eigen::Vector3d& q1);

// A capsule in the world: all within `radius_m` of the line from a to b.
struct PlacedCapsule {
  Eigen::Vector3d a = Eigen::Vector3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  double radius_m = 0.0;
};

// A body as an obstacle to sight, placed in the world.
class Obstacle {
 public:
  Obstacle(const std::vector<Capsule>& capsules, const BodyPose& pose);
  // `centre`: about the middle of the capsules.
  Obstacle(std::vector<PlacedCapsule> capsules, const Eigen::Vector3d& centre);

  // Whether the body cuts the line of sight between two points.
  bool Hides(const Eigen::Vector3d& eye, const Eigen::Vector3d& point) const;

 private:
  void BoundAll();

  std::vector<PlacedCapsule> capsules_;
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();  // of a sphere around all
  double radius_m_ = 0.0;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_SYNTHETIC_OCCLUSION_H_
