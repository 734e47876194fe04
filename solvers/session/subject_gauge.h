// The size of the subjects of a run: lengths of limbs in poses, and the run's
// scale from people triangulated from two views.
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

// Distance of two joints [m] if both were observed: inferred positions follow
// from bones or predictions and carry no information on lengths. nullopt for
// negative indices.
std::optional<double> ObservedDistance(const Pose3d& pose, int a, int b);

// Limbs in the poses of a skeleton; none for a non-human skeleton.
class Limbs {
 public:
  // Left and right of four limbs in turn, and the trunk, from mid-hip to
  // mid-shoulder.
  static constexpr size_t kSided = 8;
  static constexpr size_t kCount = kSided + 1;
  // Relative to the stature.
  static double ShareOf(size_t limb);
  static constexpr double kLeastShare = 0.4;

  explicit Limbs(const Skeleton& skeleton);

  // Lengths [m] of limbs observed in a pose.
  std::array<std::optional<double>, kCount> LengthsOf(const Pose3d& pose) const;
  // Stature estimated from one pose [m]; nullopt if too few limbs were
  // observed.
  std::optional<double> HeightOf(const Pose3d& pose) const;
  // Between two observed hips.
  std::optional<Eigen::Vector3d> MiddleOfHips(const Pose3d& pose) const;

 private:
  // Joints; -1 where the skeleton lacks one.
  struct Pair {
    int a = -1;
    int b = -1;
  };
  std::array<Pair, kSided> ends_;
  Pair hips_;
  Pair shoulders_;
};

// Determines the scale from the first ten frames in which two views agree on
// subjects: the median of the stature of people from their limbs, or of the
// size of other subjects from the distances of their joints. The scale is 1 for
// people between 0.5 and 2.3 m and for a subject that cannot be measured.
class SubjectGauge {
 public:
  // `cameras` of the frames' views. `stated_m`: the known size; 0: to be
  // measured.
  SubjectGauge(CameraRig cameras, const Skeleton& detections, double stated_m);

  void See(const DetectionFrame& frame);
  // Whether two views have shown a subject.
  bool has_begun() const { return looks_ > 0; }
  // Whether more frames have no effect. A single frame with people of plausible
  // size suffices.
  bool is_settled() const { return settled_; }
  // From the frames so far.
  SubjectScale Scale() const;

 private:
  const double cameras_m_;   // distance between them
  const CameraRig cameras_;  // in a world in which that distance is 1
  DetectionHeader header_;
  const double stated_m_;
  const Limbs limbs_;
  const bool is_human_;
  bool settled_ = false;
  int looks_ = 0;     // frames in which two views show a subject
  int measured_ = 0;  // of these, with a measured size
  std::vector<double> sizes_m_;
};

// The scale for detections of `cameras`' views, all in memory.
SubjectScale ScaleOf(const RunOptions& options, const CameraRig& cameras,
                     const DetectionSequence& detections);
// The scale of tracks in the world.
SubjectScale ScaleOf(const TrackSequence& tracks);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SESSION_SUBJECT_GAUGE_H_
