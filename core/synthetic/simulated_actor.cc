#include "core/synthetic/simulated_actor.h"

namespace kinegraph {

bool SimulatedActor::PresentAt(double time_s) const {
  return motion_.PresentAt(time_s);
}

Pose3d SimulatedActor::PoseAt(double time_s) const {
  const BodyPose body = motion_.PoseAt(time_s);
  Pose3d pose;
  pose.reserve(joints_.size());
  for (const BodyPoint& joint : joints_) {
    pose.push_back({PositionOf(joint, body), JointStatus::kObserved});
  }
  return pose;
}

SegmentPose SimulatedActor::TrunkAt(double time_s) const {
  return motion_.PoseAt(time_s)[static_cast<size_t>(Segment::kThorax)];
}

Obstacle SimulatedActor::ObstacleAt(double time_s) const {
  return Obstacle(CapsulesOf(motion_.shape()), motion_.PoseAt(time_s));
}

ActorFacts SimulatedActor::Facts() const {
  ActorFacts facts;
  facts.stature_m = motion_.shape().stature;
  facts.present = motion_.itinerary().present;
  facts.seated = motion_.itinerary().seated;
  return facts;
}

}  // namespace kinegraph
