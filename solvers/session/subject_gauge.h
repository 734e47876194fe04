// Estimates the size of a run's subjects: lengths of limbs in poses, and the
// run's scale from people triangulated from two views.
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

// Distance between two joints, in the pose's unit, if both were observed;
// inferred positions follow from bones or predictions and carry no information
// about lengths. nullopt for negative indices.
std::optional<double> ObservedDistance(const Pose3d& pose, int a, int b);
// The midpoint of two joints, under the same conditions.
std::optional<Eigen::Vector3d> ObservedMiddle(const Pose3d& pose, int a, int b);

// The limbs of a human skeleton; empty for other skeletons.
class Limbs {
 public:
  // Thigh, shank, upper arm and forearm, left and right alternating, and the
  // trunk from mid-hip to mid-shoulder.
  static constexpr size_t kSided = 8;
  static constexpr size_t kCount = kSided + 1;
  // Length relative to the stature.
  static double ShareOf(size_t limb);
  // A stature is estimated if the sum of the observed limbs' shares exceeds
  // this.
  static constexpr double kLeastShare = 0.4;

  explicit Limbs(const Skeleton& skeleton);

  // Lengths [m] of limbs observed in a pose.
  std::array<std::optional<double>, kCount> LengthsOf(const Pose3d& pose) const;
  // Stature estimated from one pose [m]; nullopt if too few limbs were
  // observed.
  std::optional<double> HeightOf(const Pose3d& pose) const;
  // The midpoint of the hips, if both were observed.
  std::optional<Eigen::Vector3d> MiddleOfHips(const Pose3d& pose) const;

 private:
  // Indices of the joints; -1 if the skeleton lacks one.
  struct Pair {
    int a = -1;
    int b = -1;
  };
  std::array<Pair, kSided> ends_;
  Pair hips_;
  Pair shoulders_;
};

// Determines the scale from the first ten frames in which two views agree on
// subjects (of at most 30 in which two views show any): the median stature of
// people, estimated from their limbs, or the median size of other subjects,
// estimated from the distances between their joints. The scale is 1 for people
// between 0.5 and 2.3 m, for people measured fewer than ten times and for
// subjects that cannot be measured. It is final at the latest 10 s, or 30
// frames if these last longer, after the first frame in which two views show a
// subject; a non-human subject that could not be measured by then is forgotten,
// because it may have been a wrong detection, and the next one is awaited.
class SubjectGauge {
 public:
  // `cameras`: one per view of the frames. `stated_m`: the known size, or 0 if
  // it must be measured.
  SubjectGauge(CameraRig cameras, const Skeleton& detections, double stated_m);

  void See(const DetectionFrame& frame);
  // Whether two views have shown a subject that is not forgotten.
  bool has_begun() const { return looks_ > 0; }
  // Whether more frames have no effect. A single frame with people of plausible
  // size suffices.
  bool is_settled() const { return settled_; }
  // The scale according to the frames so far.
  SubjectScale Scale() const;

 private:
  const double cameras_m_;   // greatest distance from the first camera
  const CameraRig cameras_;  // in a world in which that distance is 1
  DetectionHeader header_;
  const double stated_m_;
  const Limbs limbs_;
  const bool is_human_;
  bool settled_ = false;
  int looks_ = 0;     // frames in which two views show a subject
  int measured_ = 0;  // of these, frames with a measured size
  int waited_ = 0;    // frames since the first frame counted in looks_
  TimeNs begun_ = 0;  // time of that first frame
  std::vector<double> sizes_m_;
};

// The scale for a whole recording; `cameras`: one per view.
SubjectScale ScaleOf(const RunOptions& options, const CameraRig& cameras,
                     const DetectionSequence& detections);
// The scale by the sizes of tracked subjects, in the world's unit.
SubjectScale ScaleOf(const TrackSequence& tracks);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SESSION_SUBJECT_GAUGE_H_
