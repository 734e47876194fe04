// Prepares the detections of one frame; shared by tracker, replay and second
// pass.
#ifndef KINEGRAPH_CORE_TRACKING_FRAME_OBSERVATIONS_H_
#define KINEGRAPH_CORE_TRACKING_FRAME_OBSERVATIONS_H_

#include <cstddef>
#include <vector>

#include "core/base/span.h"
#include "core/data/detection.h"
#include "core/data/observation.h"
#include "core/geometry/camera.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph {

// Two observations of one view are duplicates, i.e. show one person, if the
// joints found in both are apart by less than a twentieth of the larger box's
// diagonal on average (about 9 cm on an adult), and are at least half of the
// joints of the observation that has fewer. Two people overlap that well only
// for a frame or two.
//
// Of the first `count` observations, which must be of one view, keeps one of
// each group of duplicates: the one with the most joints, then the most
// confident one, then the first. Returns the number kept; they are moved to the
// front, in the order of their groups' first members, and the others stay
// behind them, for their memory to be reused.
size_t SuppressDuplicates(size_t count, std::vector<Observation>* observations);

// Observations of each view of a frame, converted to the skeleton of the
// tracks. Reuses its memory between frames.
class FrameObservations {
 public:
  // `cameras` must outlive the object. Detections with too few found joints are
  // left out: `min_found_joints` is stated for 17 joints and scaled to the
  // association joints of `tracks` (ScaledJoints).
  FrameObservations(const CameraRig& cameras, const Skeleton& detections,
                    const Skeleton& tracks, double min_found_joints,
                    bool suppress_duplicates);

  // Throws OptionError unless the frame has one view per camera.
  void Prepare(const DetectionFrame& frame);

  size_t view_count() const { return observations_.size(); }
  // Valid until the next Prepare.
  Span<Observation> OfView(size_t view_idx) const {
    return {observations_[view_idx].data(), counts_[view_idx]};
  }

 private:
  const CameraRig* cameras_;
  std::vector<int> joint_map_;
  std::vector<int> counted_joints_;
  int min_found_joints_;
  bool suppress_duplicates_;
  std::vector<std::vector<Observation>> observations_;  // [view]
  std::vector<size_t> counts_;                          // [view]
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_TRACKING_FRAME_OBSERVATIONS_H_
