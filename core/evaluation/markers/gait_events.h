// Times of foot contact and foot off, from the motion of joints and from force
// plates.
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
  bool is_contact = true;  // heel strike or landing; else foot off
  double time_s = 0.0;
};

struct FootEvents {
  // true: events by the feet's displacement relative to the pelvis (Zeni,
  // Richards, Higginson 2008). false: by the vertical speed of the forefoot,
  // foot off at half of its upward peak, landing when it has fallen to half of
  // its downward peak.
  bool is_walk = false;
  std::vector<FootEvent> events;  // by foot, ascending
};

// Events of the first person of the frames, from heels and toes, or ankles
// where the skeleton lacks them. `up` is the world's up direction. No events
// without any of these.
FootEvents FindFootEvents(const TrackSequence& motion,
                          const Eigen::Vector3d& up);

// Median time between contacts of the same foot in walking [s]; NaN if no foot
// has two contacts, and for other motion.
double StrideTime(const FootEvents& events);

// An event of a plate, and the time by which the matched event of the motion is
// later.
struct TimedEvent {
  FootEvent plate;
  double found_minus_plate_s = 0.0;  // NaN: no such event within 0.15 s
};

// An event of a plate is a crossing of 20 N; its foot is the one whose ankle is
// nearest to the plate. Loads and pauses of less than 50 ms are ignored.
std::vector<TimedEvent> CompareWithPlates(const std::vector<ForcePlate>& plates,
                                          const FootEvents& found,
                                          const TrackSequence& motion,
                                          const Eigen::Vector3d& up);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_MARKERS_GAIT_EVENTS_H_
