// The unit of length of a run. What tracker and estimators know of distances,
// speeds and noise, constants and options alike, is known of people. A mouse or
// a fly moves as they do in a world of its own size: the run divides the world
// by this scale, and multiplies what it answers.
#ifndef KINEGRAPH_SOLVERS_SESSION_SUBJECT_SCALE_H_
#define KINEGRAPH_SOLVERS_SESSION_SUBJECT_SCALE_H_

#include <vector>

#include "core/data/detection.h"
#include "core/data/pose.h"
#include "core/data/view_bias.h"
#include "core/geometry/camera.h"
#include "core/io/configuration/refinement_record.h"
#include "solvers/noise/person_noise.h"
#include "solvers/scene/refine.h"
#include "solvers/session/limbs.h"
#include "solvers/session/options.h"

namespace kinegraph {

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

  CameraRig IntoRun(CameraRig cameras) const;
  // Places in the world, and what is known beforehand of the detector's bias.
  RunOptions IntoRun(RunOptions options) const;
  TrackFrame IntoRun(TrackFrame frame) const {
    return Times(1 / metres_, frame);
  }

  CameraRig IntoWorld(CameraRig cameras) const;
  TrackFrame IntoWorld(TrackFrame frame) const { return Times(metres_, frame); }
  LearntNoise IntoWorld(LearntNoise noise) const;
  ViewBias IntoWorld(ViewBias bias) const;
  // Changes of the cameras' centres, their sigmas and covariance.
  void IntoWorld(Refinement* refinement) const;

 private:
  static TrackFrame Times(double factor, TrackFrame frame);

  double metres_ = 1.0;
};

// Finds the scale from the first frames in which two views show the subject:
// the median, over pairs of views and frames, of the stature that limbs tell of
// people, and of the extent of what is no human. People between 0.5 and 2.3 m,
// and a subject that nothing measures, have the scale 1.
class SubjectGauge {
 public:
  // `cameras` of the frames' views. `stated_m`: the size; 0: to be measured.
  SubjectGauge(CameraRig cameras, const Skeleton& detections, double stated_m);

  void See(const DetectionFrame& frame);
  // Whether two views have shown anybody.
  bool has_begun() const { return looks_ > 0; }
  // Whether more frames change nothing. One look at people is enough.
  bool is_settled() const { return settled_; }
  // From what was seen so far.
  SubjectScale Scale() const;

 private:
  void SeePair(size_t a, size_t b, const DetectionFrame& frame);

  const double cameras_m_;  // how far apart they stand
  CameraRig cameras_;       // in a world in which that is 1
  const double stated_m_;
  const Limbs limbs_;
  const bool is_human_;
  bool settled_ = false;
  int looks_ = 0;     // frames in which two views show anybody
  int measured_ = 0;  // of them, that told a size
  std::vector<double> sizes_m_;
};

// The scale for detections of `cameras`' views, all at hand.
SubjectScale ScaleOf(const RunOptions& options, const CameraRig& cameras,
                     const DetectionSequence& detections);
// The scale of tracks that stand in the world.
SubjectScale ScaleOf(const TrackSequence& tracks);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SESSION_SUBJECT_SCALE_H_
