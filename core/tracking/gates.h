// Gates of the front end in metres and seconds, turned into the pixels and
// frames that it works with, for any focal length, distance and frame rate.
#ifndef KINEGRAPH_CORE_TRACKING_GATES_H_
#define KINEGRAPH_CORE_TRACKING_GATES_H_

#include "core/base/options.h"
#include "core/geometry/camera.h"

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

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_TRACKING_GATES_H_
