// When feet touch the floor and leave it, from the motion of joints, and from
// force plates.
#ifndef KINEGRAPH_CORE_EVALUATION_MARKERS_GAIT_EVENTS_H_
#define KINEGRAPH_CORE_EVALUATION_MARKERS_GAIT_EVENTS_H_

#include <Eigen/Core>
#include <vector>

#include "core/data/force_plate.h"
#include "core/data/pose.h"

namespace kinegraph {

enum class Foot { kLeft, kRight };

struct FootEvent {
  Foot foot = Foot::kLeft;
  bool is_contact = true;  // heel strike or landing; else the foot leaves
  double time_s = 0.0;
};

struct FootEvents {
  // By the feet's way relative to the pelvis (Zeni, Richards, Higginson 2008);
  // else nobody walked, and the forefoot's vertical speed decides: it leaves
  // when it has half of the speed with which it rises, and lands when it has
  // lost half of that with which it falls.
  bool is_walk = false;
  std::vector<FootEvent> events;  // by foot, ascending
};

// Of the first person of the frames; heels and toes, where they are missing the
// ankles. `up` is the world's. Without ankles no events.
FootEvents FindFootEvents(const TrackSequence& motion,
                          const Eigen::Vector3d& up);

// Median time between contacts of the same foot [s]; NaN for fewer than two.
double StrideTime(const FootEvents& events);

// An event of a plate and the one found for it.
struct TimedEvent {
  FootEvent plate;
  double found_minus_plate_s = 0.0;  // NaN: none of that foot within 0.15 s
};

// The load passes 20 N; the foot is that whose ankle is nearest to the plate.
// Loads that last, or pause, less than 50 ms are knocks.
std::vector<TimedEvent> CompareWithPlates(const std::vector<ForcePlate>& plates,
                                          const FootEvents& found,
                                          const TrackSequence& motion,
                                          const Eigen::Vector3d& up);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_MARKERS_GAIT_EVENTS_H_
