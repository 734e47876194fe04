// How large whom a run tracks is: lengths of limbs in poses, and the run's
// scale from what two views show.
#ifndef KINEGRAPH_SOLVERS_SESSION_SUBJECT_GAUGE_H_
#define KINEGRAPH_SOLVERS_SESSION_SUBJECT_GAUGE_H_

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "core/data/detection.h"
#include "core/data/pose.h"
#include "core/geometry/camera.h"
#include "core/skeleton/skeleton.h"
#include "solvers/session/options.h"
#include "solvers/session/subject_scale.h"

namespace kinegraph {

// Distance of two joints [m] where both were observed: what a bone factor or a
// prediction filled in says nothing new. Joints below zero are none.
std::optional<double> ObservedDistance(const Pose3d& pose, int a, int b);

// Where limbs are in the poses of a skeleton; one that is no human's has none.
class Limbs {
 public:
  // Left and right of four limbs in turn, and the trunk, from the middle of the
  // hips to that of the shoulders.
  static constexpr size_t kSided = 8;
  static constexpr size_t kCount = kSided + 1;
  // Of the stature; less than the least of all together says nothing of it.
  static double ShareOf(size_t limb);
  static constexpr double kLeastShare = 0.4;

  explicit Limbs(const Skeleton& skeleton);

  // Lengths [m] that were observed in a pose.
  std::array<std::optional<double>, kCount> LengthsOf(const Pose3d& pose) const;
  // Stature that one pose tells [m]; nullopt where too little was observed.
  std::optional<double> HeightOf(const Pose3d& pose) const;
  // Between two hips that were observed.
  std::optional<Eigen::Vector3d> MiddleOfHips(const Pose3d& pose) const;

 private:
  // Joints; -1 where the skeleton has none.
  struct Pair {
    int a = -1;
    int b = -1;
  };
  std::array<Pair, kSided> ends_;
  Pair hips_;
  Pair shoulders_;
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

#endif  // KINEGRAPH_SOLVERS_SESSION_SUBJECT_GAUGE_H_
