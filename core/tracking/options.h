// Everything that steers the front end, in the tables of a configuration.
#ifndef KINEGRAPH_CORE_TRACKING_OPTIONS_H_
#define KINEGRAPH_CORE_TRACKING_OPTIONS_H_

#include "core/association/affinity.h"
#include "core/base/options.h"
#include "core/reconstruction/initialisation.h"
#include "core/reconstruction/reconstruction.h"

namespace kinegraph {

// Track life.
struct TrackLifeOptions {
  int64_t confirm_hits = 3;      // successful updates, birth included
  double max_age_frames = 10.0;  // deleted this long after the last update
  // Detections with fewer found joints are noise and never looked at.
  double min_found_joints = 5.0;  // of 17
  // Also write the frames of a track before it was confirmed, once it is.
  bool backfill = false;
  // Write confirmed frames without an update when an update follows within
  // this time: the estimator bridges them. 0: never.
  double max_gap_frames = 0.0;
  // Offline: associate the whole take again with the smoothed tracks
  // (core/tracking/second_pass.h).
  bool second_pass = false;

  void Describe(OptionVisitor& visitor);
};

struct TrackerOptions {
  AssociationOptions association;
  ReconstructionOptions reconstruction;
  InitialisationOptions initialisation;
  TrackLifeOptions life;

  // Tables [association], [reconstruction], [initialisation], [tracking].
  void Describe(OptionVisitor& visitor);
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_TRACKING_OPTIONS_H_
