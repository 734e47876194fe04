// A person whose motion a simulation made up: steps, arm swing, sitting,
// gestures.
#ifndef KINEGRAPH_CORE_SYNTHETIC_SIMULATED_ACTOR_H_
#define KINEGRAPH_CORE_SYNTHETIC_SIMULATED_ACTOR_H_

#include <array>
#include <cstdint>
#include <vector>

#include "core/synthetic/actor.h"
#include "core/synthetic/body.h"
#include "core/synthetic/crowd.h"

namespace kinegraph {

// A foot on the ground: where the ankle stands when the foot is flat.
struct Footprint {
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();
  double yaw = 0.0;
};

// One swing of one foot.
struct Step {
  TimeSpan swing;
  Footprint from;
  Footprint to;
  double length_m = 0.0;  // forward part of the way
};

class SimulatedActor : public Actor {
 public:
  // `skeleton` is the scene's; `seed` draws personal habits;
  // `trunk_flexibility` scales the turning of thorax and head against the
  // pelvis (0: trunk and head are one rigid part).
  SimulatedActor(const BodyShape& shape, const Skeleton& skeleton,
                 Itinerary itinerary, TimeSpan span, double trunk_flexibility,
                 uint64_t seed);

  const Itinerary& itinerary() const { return itinerary_; }
  // Swings of the left and the right foot, ascending.
  const std::array<std::vector<Step>, 2>& steps() const { return steps_; }
  Posture PostureAt(double time_s) const;

  bool PresentAt(double time_s) const override;
  Pose3d PoseAt(double time_s) const override;
  SegmentPose TrunkAt(double time_s) const override;
  Obstacle ObstacleAt(double time_s) const override;
  ActorFacts Facts() const override;

 private:
  // Small slow movements with phases of their own.
  struct Habits {
    double arm_swing = 1.0;
    double elbow = 0.25;  // [rad]
    double stance = 1.0;
    std::array<double, 6> phase{};  // [rad]
  };

  BodyPose BodyAt(double time_s) const {
    return PlaceBody(shape_, PostureAt(time_s));
  }
  Footprint Neutral(double time_s, int side) const;
  double StepPeriod(double time_s) const;
  bool SeatedAround(double time_s) const;
  void PlanSteps(TimeSpan span);
  FootPosture FootAt(double time_s, int side) const;
  double SeatShare(double time_s, double* transition) const;
  ArmPosture ArmAt(double time_s, int side, double swing, double seat) const;

  BodyShape shape_;
  std::vector<BodyPoint> joints_;  // of the scene's skeleton
  Itinerary itinerary_;
  double trunk_flexibility_;
  Habits habits_;
  std::array<std::vector<Step>, 2> steps_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_SYNTHETIC_SIMULATED_ACTOR_H_
