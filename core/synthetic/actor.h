// A person of a synthetic scene, simulated or recorded: a pure function of
// time, so that any camera may sample any moment.
#ifndef KINEGRAPH_CORE_SYNTHETIC_ACTOR_H_
#define KINEGRAPH_CORE_SYNTHETIC_ACTOR_H_

#include <string>
#include <vector>

#include "core/data/pose.h"
#include "core/synthetic/body.h"

namespace kinegraph {

struct TimeSpan {
  double begin_s = 0.0;
  double end_s = 0.0;
};

// What is told about a person beside the poses.
struct ActorFacts {
  double stature_m = 0.0;         // estimated where motion was recorded
  std::vector<TimeSpan> present;  // in the scene
  std::vector<TimeSpan> seated;
  std::string clip;  // file of the recorded motion; empty: simulated
  TrackId clip_id;   // the person's in that file
};

// Times are the scene's [s], positions its world's [m].
class Actor {
 public:
  virtual ~Actor() = default;

  virtual bool PresentAt(double time_s) const = 0;
  // One entry a joint of the scene's skeleton; asked only where present, as
  // the two below.
  virtual Pose3d PoseAt(double time_s) const = 0;
  // x forward, y to the left: what a detector calls the person's front.
  virtual SegmentPose TrunkAt(double time_s) const = 0;
  // The body as what hides others.
  virtual Obstacle ObstacleAt(double time_s) const = 0;

  virtual ActorFacts Facts() const = 0;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_SYNTHETIC_ACTOR_H_
