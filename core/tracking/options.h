// All options of the front end, by configuration table. "The paper" is Chu et
// al. (2021).
#ifndef KINEGRAPH_CORE_TRACKING_OPTIONS_H_
#define KINEGRAPH_CORE_TRACKING_OPTIONS_H_

#include "core/association/options.h"
#include "core/base/options.h"
#include "core/geometry/camera.h"
#include "core/reconstruction/options.h"

namespace kinegraph {

struct TrackerOptions;

enum class GateUnits {
  kPixels,  // the keys in pixels and frames apply, as in the paper
  kMetres,  // the gates are derived from the keys of this table
};

// Table [gates]. A gate in pixels is a length at the working distance plus the
// detector's error, which does not depend on the distance:
//   alpha_epi = alpha_group = alpha_filter = s epipolar_m + detector_px
//   alpha_2d  = s (reach_m + speed_mps / frame_rate) + motion_detector_px
// with s = focal length / working distance [px/m], the median over cameras. The
// defaults give 65 and 84 px for Shelf's cameras (s = 310 px/m, 25 Hz; the
// paper: 60 and 70), 15 and 26 for Campus' (48 px/m; the paper: 15 and 30).
struct GateOptions {
  GateUnits units = GateUnits::kPixels;
  double speed_mps = 2.6;
  double working_distance_m = 0.0;  // 0: WorkingDistance of the cameras

  // Constants, not keys.
  double epipolar_m = 0.19;
  double detector_px = 6.0;
  double reach_m = 0.12;
  double motion_detector_px = 15.0;
  // tau, lambda_a and lambda_t of the paper at 25 Hz, in seconds.
  double view_age_s = 0.12;
  double affinity_decay_per_s = 75.0;
  double view_decay_per_s = 125.0;

  void Describe(OptionVisitor& visitor);
};

// Median over the cameras of the depth [m] of the point nearest to all optical
// axes; 4 m where that point is undetermined (a single camera, axes nearly
// parallel) or behind the cameras.
double WorkingDistance(const CameraRig& cameras);

// Median over the cameras of focal length / working distance [px/m].
double PixelsPerMetre(const CameraRig& cameras, double working_distance_m);

// The options, with gates in pixels and frames filled in if gates.units is
// kMetres.
TrackerOptions WithScaledGates(TrackerOptions options, const CameraRig& cameras,
                               double frame_rate_hz);

// Track life. Times are in seconds, so that a person may be hidden for as long
// at 120 Hz as at 25 Hz; below 12.5 Hz max_age_s and max_gap_s are extended
// (LifeInFrames). Paper mode counts frames as the paper does at 25 Hz: there a
// second is 25 frames at any rate of the recording.
struct TrackLifeOptions {
  double confirm_s = 0.08;  // birth to the confirming update if none fails
  double max_age_s = 0.4;   // deleted this long after the last update
  // Detections with fewer found joints are treated as noise and ignored.
  double min_found_joints = 5.0;  // of 17
  // Also write the frames of a track before its confirmation.
  bool backfill = false;
  // Gaps of a confirmed track (frames without an update, followed by one) are
  // written up to this length: the estimator bridges them. 0: never.
  double max_gap_s = 0.0;
  // Offline: associate the whole recording again with the smoothed tracks
  // (core/tracking/second_pass.h).
  bool second_pass = false;

  // Not keys of this table: the times above in frames of the recording, set by
  // the run. Hits are successful updates, birth included.
  int64_t confirm_hits = 3;
  double max_age_frames = 10.0;
  double max_gap_frames = 0.0;
  bool in_seconds = false;          // graph mode: conversion to frames is
                                    // pending
  bool independent_frames = false;  // every frame is a separate recording

  void Describe(OptionVisitor& visitor);
};

// The options with the times also given in frames of a recording's nominal rate
// if their conversion is pending (in_seconds): below 12.5 Hz ages and gaps grow
// with the frame interval, up to five times; confirmation takes at least two
// hits, but only one where frames are so rare that a track does not outlive a
// missed one. Where frames are independent, it takes one hit in either mode.
TrackLifeOptions LifeInFrames(const TrackLifeOptions& options,
                              double frame_rate_hz);

// Additions to the paper's association (core/tracking/association_policy.h).
enum class AssociationRules { kPaper, kGraph };

struct TrackerOptions {
  AssociationOptions association;
  ReconstructionOptions reconstruction;
  InitialisationOptions initialisation;
  TrackLifeOptions life;
  GateOptions gates;

  // Not a key: set by the run.
  AssociationRules rules = AssociationRules::kPaper;
  bool suppresses_duplicates() const {
    return rules == AssociationRules::kGraph;
  }

  // These options with track life and reach converted to frames of a
  // recording's nominal rate. In paper mode reach and prediction horizon become
  // 0, and every seen joint can count as lost (LostRule::kSeen).
  TrackerOptions At(double frame_rate_hz) const;

  // Tables [association], [reconstruction], [initialisation], [tracking],
  // [gates].
  void Describe(OptionVisitor& visitor);
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_TRACKING_OPTIONS_H_
