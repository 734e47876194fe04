// A person whose motion a simulation made up.
#ifndef KINEGRAPH_CORE_SYNTHETIC_SIMULATED_ACTOR_H_
#define KINEGRAPH_CORE_SYNTHETIC_SIMULATED_ACTOR_H_

#include <utility>
#include <vector>

#include "core/synthetic/actor.h"
#include "core/synthetic/body.h"
#include "core/synthetic/motion.h"

namespace kinegraph {

class SimulatedActor : public Actor {
 public:
  // `joints`: the points of the scene's skeleton on the body.
  SimulatedActor(PersonMotion motion, std::vector<BodyPoint> joints)
      : motion_(std::move(motion)), joints_(std::move(joints)) {}

  const PersonMotion& motion() const { return motion_; }

  bool PresentAt(double time_s) const override;
  Pose3d PoseAt(double time_s) const override;
  SegmentPose TrunkAt(double time_s) const override;
  Obstacle ObstacleAt(double time_s) const override;
  ActorFacts Facts() const override;

 private:
  PersonMotion motion_;
  std::vector<BodyPoint> joints_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_SYNTHETIC_SIMULATED_ACTOR_H_
