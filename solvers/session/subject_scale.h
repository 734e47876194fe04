// The unit of length of a run. Constants and options that describe the subject
// (gates, speeds, noise) hold for people. A mouse or a fly moves similarly
// relative to its size, so these remain unchanged; instead the run divides the
// world by this scale and multiplies its results by it. Options that describe
// the room (gates.working_distance, identity.entries) and a given bias of the
// detector are in metres of the world and are divided as well.
#ifndef KINEGRAPH_SOLVERS_SESSION_SUBJECT_SCALE_H_
#define KINEGRAPH_SOLVERS_SESSION_SUBJECT_SCALE_H_

#include "core/data/pose.h"
#include "core/data/view_bias.h"
#include "core/geometry/camera.h"
#include "solvers/noise/learnt_noise.h"
#include "solvers/session/options.h"

namespace kinegraph {

struct Refinement;  // solvers/cameras/refine.h

// The stature for which the constants hold.
inline constexpr double kPersonSize_m = 1.7;

class SubjectScale {
 public:
  SubjectScale() = default;  // people: all values unchanged, bit for bit
  // The scale of a subject of this size [m], i.e. stature or extent. Throws
  // std::logic_error unless the size is positive and finite.
  static SubjectScale OfSize(double size_m);

  // Metres of the world per metre of the run.
  double metres() const { return metres_; }
  double size_m() const;
  bool is_one() const { return metres_ == 1.0; }

  CameraRig IntoRun(const CameraRig& cameras) const;
  // Scales the options that are in metres of the world: working distance,
  // entries and a given bias of the detector.
  RunOptions IntoRun(RunOptions options) const;
  TrackFrame IntoRun(TrackFrame frame) const {
    return Times(1 / metres_, frame);
  }

  CameraRig IntoWorld(const CameraRig& cameras) const;
  TrackFrame IntoWorld(TrackFrame frame) const { return Times(metres_, frame); }
  LearntNoise IntoWorld(LearntNoise noise) const;
  ViewBias IntoWorld(ViewBias bias) const;
  // Scales the changes of the cameras' centres, their sigmas and covariance.
  void IntoWorld(Refinement* refinement) const;

 private:
  static TrackFrame Times(double factor, TrackFrame frame);

  double metres_ = 1.0;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SESSION_SUBJECT_SCALE_H_
