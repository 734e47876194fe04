// Everything that steers the front end, in the tables of a configuration.
#ifndef KINEGRAPH_CORE_TRACKING_OPTIONS_H_
#define KINEGRAPH_CORE_TRACKING_OPTIONS_H_

#include "core/association/options.h"
#include "core/base/options.h"
#include "core/geometry/camera.h"
#include "core/reconstruction/options.h"

namespace kinegraph {

struct TrackerOptions;

enum class GateUnits {
  kPixels,  // the keys in pixels and frames hold, as the paper gives them
  kMetres,  // they follow from the keys of this table
};

// Table [gates]. A gate in pixels is the length at the working distance plus
// what a detector is wrong by however far away people are:
//   alpha_epi = alpha_group = alpha_filter = s epipolar_m + detector_px
//   alpha_2d  = s (reach_m + speed_mps / frame_rate) + motion_detector_px
// with s = focal length / working distance [px/m], the median over cameras.
// With the defaults Shelf's cameras (s = 310 px/m, 25 Hz) get 65 and 85 px
// beside the paper's 60 and 70, Campus' (48 px/m) 15 and 26 beside 15 and 30.
struct GateOptions {
  GateUnits units = GateUnits::kPixels;
  double speed_mps = 2.6;
  double working_distance_m = 0.0;  // 0: where the optical axes meet

  // Constants, no keys.
  double epipolar_m = 0.19;
  double detector_px = 6.0;
  double reach_m = 0.12;
  double motion_detector_px = 15.0;
  // tau, lambda_a and lambda_t of the paper's 25 Hz in time.
  double view_age_s = 0.12;
  double affinity_decay_per_s = 75.0;
  double view_decay_per_s = 125.0;

  void Describe(OptionVisitor& visitor);
};

// Distance [m] of the cameras, in the median, from the point nearest to all
// optical axes; 4 m where the axes are nearly parallel or meet behind the
// cameras, and no point is near to them.
double WorkingDistance(const CameraRig& cameras);

// Median over the cameras of focal length / working distance [px/m].
double PixelsPerMetre(const CameraRig& cameras, double working_distance_m);

// The options with pixels and frames filled in where gates.units says so.
TrackerOptions WithScaledGates(TrackerOptions options, const CameraRig& cameras,
                               double frame_rate_hz);

// Track life. Times are seconds, so that a person may be hidden as long at
// 120 Hz as at 25 Hz. Paper mode counts frames, as the paper does at 25 Hz: a
// second is 25 frames there, whatever the recording's rate.
struct TrackLifeOptions {
  double confirm_s = 0.08;  // birth to the update that confirms
  double max_age_s = 0.4;   // deleted this long after the last update
  // Detections with fewer found joints are noise and never looked at.
  double min_found_joints = 5.0;  // of 17
  // Also write the frames of a track before it was confirmed, once it is.
  bool backfill = false;
  // Write confirmed frames without an update when an update follows within
  // this time: the estimator bridges them. 0: never.
  double max_gap_s = 0.0;
  // Offline: associate the whole recording again with the smoothed tracks
  // (core/tracking/second_pass.h).
  bool second_pass = false;

  // Set by the run, no keys of this table: the times above in frames of the
  // recording; hits are successful updates, birth included.
  int64_t confirm_hits = 3;
  double max_age_frames = 10.0;
  double max_gap_frames = 0.0;
  bool in_seconds = false;          // frames are yet to be told: graph mode
  bool independent_frames = false;  // each frame is a recording of its own

  void Describe(OptionVisitor& visitor);
};

// The same life counted in frames of a recording's nominal rate. A track is
// confirmed at two hits at least, but at once where frames are so rare that a
// track could not miss one, and where they are independent.
TrackLifeOptions LifeInFrames(const TrackLifeOptions& options,
                              double frame_rate_hz);

// What association does beside the paper (core/tracking/association_policy.h).
enum class AssociationRules { kPaper, kGraph };

struct TrackerOptions {
  AssociationOptions association;
  ReconstructionOptions reconstruction;
  InitialisationOptions initialisation;
  TrackLifeOptions life;
  GateOptions gates;

  // Set by the run, no key.
  AssociationRules rules = AssociationRules::kPaper;
  bool suppresses_duplicates() const {
    return rules == AssociationRules::kGraph;
  }

  // With the life in frames and the reach a frame, for a recording's nominal
  // rate.
  TrackerOptions At(double frame_rate_hz) const;

  // Tables [association], [reconstruction], [initialisation], [tracking],
  // [gates].
  void Describe(OptionVisitor& visitor);
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_TRACKING_OPTIONS_H_
