#include "core/tracking/options.h"

namespace kinegraph {

void TrackLifeOptions::Describe(OptionVisitor& visitor) {
  visitor.Integer("confirm_hits", &confirm_hits, Between(1, 1000), "updates",
                  "successful updates, birth included, before a track counts");
  visitor.Number("max_age", &max_age_frames, Positive(), "frames",
                 "a track without an update is deleted after this");
  visitor.Number("min_found_joints", &min_found_joints, Between(0.0, 17.0),
                 "joints of 17", "detections with fewer are noise");
  visitor.Boolean("backfill", &backfill,
                  "write a track's frames before it was confirmed as well");
  visitor.Number("max_gap", &max_gap_frames, NonNegative(), "frames",
                 "gaps up to this are written as the estimator bridges them");
  visitor.Boolean("second_pass", &second_pass,
                  "offline: associate again with the smoothed tracks");
}

void TrackerOptions::Describe(OptionVisitor& visitor) {
  visitor.Enter("association");
  association.Describe(visitor);
  visitor.Leave();
  visitor.Enter("reconstruction");
  reconstruction.Describe(visitor);
  visitor.Leave();
  visitor.Enter("initialisation");
  initialisation.Describe(visitor);
  visitor.Leave();
  visitor.Enter("tracking");
  life.Describe(visitor);
  visitor.Leave();
}

}  // namespace kinegraph
