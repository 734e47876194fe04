// What people of a synthetic scene do.
#ifndef KINEGRAPH_CORE_SYNTHETIC_CROWD_OPTIONS_H_
#define KINEGRAPH_CORE_SYNTHETIC_CROWD_OPTIONS_H_

#include "core/base/options.h"

namespace kinegraph {

struct CrowdOptions {
  double area_radius_m = 3.0;     // people walk inside this circle
  double walking_speed_ms = 1.1;  // mean over people
  double min_distance_m = 0.55;   // closest that two people pass (centres)
  // After each walk the next deed is drawn with these weights.
  double walking = 0.55;
  double standing = 0.2;
  double turning = 0.1;
  double sitting = 0.15;
  double arm_motion = 0.3;  // share of time with a gesture
  double visitors = 0.3;    // share of people who come and go
  double crossing = 0.7;    // share of walks led through the middle

  void Describe(OptionVisitor& visitor);
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_SYNTHETIC_CROWD_OPTIONS_H_
