// The unit of length of a run. What tracker and estimators know of distances,
// speeds and noise, constants and options alike, is known of people. A mouse or
// a fly moves as they do in a world of its own size: the run divides the world
// by this scale, and multiplies what it answers.
#ifndef KINEGRAPH_SOLVERS_SESSION_SUBJECT_SCALE_H_
#define KINEGRAPH_SOLVERS_SESSION_SUBJECT_SCALE_H_

#include "core/data/pose.h"
#include "core/data/view_bias.h"
#include "core/geometry/camera.h"
#include "solvers/noise/learnt_noise.h"
#include "solvers/session/options.h"

namespace kinegraph {

struct Refinement;  // solvers/cameras/refine.h

// Whom the constants are made for.
inline constexpr double kPersonSize_m = 1.7;

class SubjectScale {
 public:
  SubjectScale() = default;  // people: everything stays as it is, bit by bit
  // Of a subject as large as told [m]: its stature, or as long as it is.
  static SubjectScale OfSize(double size_m);

  // Metres of the world in a metre of the run.
  double metres() const { return metres_; }
  double size_m() const;
  bool is_one() const { return metres_ == 1.0; }

  CameraRig IntoRun(const CameraRig& cameras) const;
  // Places in the world, and what is known beforehand of the detector's bias.
  RunOptions IntoRun(RunOptions options) const;
  TrackFrame IntoRun(TrackFrame frame) const {
    return Times(1 / metres_, frame);
  }

  CameraRig IntoWorld(const CameraRig& cameras) const;
  TrackFrame IntoWorld(TrackFrame frame) const { return Times(metres_, frame); }
  LearntNoise IntoWorld(LearntNoise noise) const;
  ViewBias IntoWorld(ViewBias bias) const;
  // Changes of the cameras' centres, their sigmas and covariance.
  void IntoWorld(Refinement* refinement) const;

 private:
  static TrackFrame Times(double factor, TrackFrame frame);

  double metres_ = 1.0;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SESSION_SUBJECT_SCALE_H_
