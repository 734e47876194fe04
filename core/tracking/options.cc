#include "core/tracking/options.h"

#include <algorithm>
#include <cmath>

namespace kinegraph {

void TrackLifeOptions::Describe(OptionVisitor& visitor) {
  visitor.Number("confirm_s", &confirm_s, Between(0.0, 40.0), "s",
                 "a track is confirmed by an update this long after its birth; "
                 "in paper mode a second is 25 frames");
  visitor.Number("max_age_s", &max_age_s, Positive(), "s",
                 "a track without an update is deleted after this; in paper "
                 "mode a second is 25 frames");
  visitor.Number("min_found_joints", &min_found_joints, Between(0.0, 17.0),
                 "joints of 17", "detections with fewer are noise");
  visitor.Boolean("backfill", &backfill,
                  "also write a track's frames before it was confirmed");
  visitor.Number("max_gap_s", &max_gap_s, NonNegative(), "s",
                 "graph mode: gaps up to this are bridged and written");
  visitor.Boolean("second_pass", &second_pass,
                  "offline: associate again with the smoothed tracks");
}

TrackLifeOptions LifeInFrames(const TrackLifeOptions& options,
                              double frame_rate_hz) {
  TrackLifeOptions life = options;
  life.in_seconds = false;
  if (options.in_seconds) {
    life.max_age_frames = options.max_age_s * frame_rate_hz;
    life.max_gap_frames = options.max_gap_s * frame_rate_hz;
    life.confirm_hits = std::max<int64_t>(
        2, 1 + std::llround(options.confirm_s * frame_rate_hz));
    // One and a half: at one missed frame the clock's slack is used up.
    if (life.max_age_frames < 1.5) life.confirm_hits = 1;
  }
  if (options.independent_frames) life.confirm_hits = 1;
  return life;
}

TrackerOptions TrackerOptions::At(double frame_rate_hz) const {
  TrackerOptions options = *this;
  options.life = LifeInFrames(life, frame_rate_hz);
  options.association.reach_m_per_frame =
      life.in_seconds ? association.max_speed_mps / frame_rate_hz : 0.0;
  options.association.horizon_s =
      life.in_seconds ? association.prediction_s : 0.0;
  if (!life.in_seconds) options.reconstruction.lost = LostRule::kSeen;
  return options;
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
  visitor.Enter("gates");
  gates.Describe(visitor);
  visitor.Leave();
}

}  // namespace kinegraph
