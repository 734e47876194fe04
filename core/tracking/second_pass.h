// Offline: a take associated again with tracks that were smoothed over all of
// it, and estimated anew.
#ifndef KINEGRAPH_CORE_TRACKING_SECOND_PASS_H_
#define KINEGRAPH_CORE_TRACKING_SECOND_PASS_H_

#include <map>
#include <memory>
#include <vector>

#include "core/association/view_matching.h"
#include "core/data/detection.h"
#include "core/data/pose.h"
#include "core/geometry/epipolar.h"
#include "core/reconstruction/reconstruction.h"
#include "core/tracking/estimator.h"
#include "core/tracking/frame_observations.h"
#include "core/tracking/options.h"

namespace kinegraph {

// The first pass associates with what it knows of the past; the smoothed tracks
// know the frame itself and what follows. Each frame's detections are matched
// with the poses of that very frame, by the affinity of a pose one frame old.
// People, their identities and the frames in which they are written stay those
// of the first pass; what belongs to them may change.
class SecondPass {
 public:
  // As Tracker's; `estimator` makes the one that is written.
  SecondPass(SceneModel scene, const Skeleton& detection_skeleton,
             const TrackerOptions& options, EstimatorFactory estimator);

  // The next frame in ascending order, and what the first pass wrote for it
  // (frames without people may be left out).
  void Process(const DetectionFrame& frame, const TrackFrame& first_pass);
  // Estimates everyone, on up to `threads` threads, and gives every frame.
  // Nobody is lost: where the estimate has no joint, the first pass's stays.
  std::vector<TrackFrame> Finish(int threads);

 private:
  void AddPerson(const DetectionFrame& frame, const PersonPose& person,
                 size_t target);

  SceneModel scene_;
  TrackerOptions options_;
  EstimatorFactory make_estimator_;
  EpipolarGeometry epipolar_;
  FrameObservations observations_;
  ViewMatcher matcher_;
  Reconstructor reconstructor_;

  std::vector<TrackFrame> frames_;  // with the first pass's people
  std::map<TrackId, std::unique_ptr<Estimator>> estimators_;

  // This frame's work, kept to reuse its memory.
  std::vector<AssociationTarget> targets_;
  std::vector<std::vector<int>> matches_;  // [view][target]
  std::vector<UsedView> used_views_;
  Reconstruction reconstruction_;
  EstimatorFrame work_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_TRACKING_SECOND_PASS_H_
