#include "core/tracking/frame_observations.h"

#include <algorithm>
#include <string>

#include "core/base/error.h"
#include "core/tracking/duplicate_suppression.h"

namespace kinegraph {

FrameObservations::FrameObservations(const CameraRig& cameras,
                                     const Skeleton& detections,
                                     const Skeleton& tracks,
                                     double min_found_joints,
                                     bool suppress_duplicates)
    : cameras_(&cameras),
      joint_map_(MapByName(detections, tracks)),
      counted_joints_(tracks.association_joints()),
      min_found_joints_(
          std::max(1, ScaledJoints(min_found_joints, counted_joints_.size()))),
      suppress_duplicates_(suppress_duplicates),
      observations_(cameras.size()),
      counts_(cameras.size(), 0) {}

void FrameObservations::Prepare(const DetectionFrame& frame) {
  if (frame.views.size() != cameras_->size()) {
    throw OptionError("frame " + std::to_string(frame.frame),
                      "found " + std::to_string(frame.views.size()) +
                          " views, expected one for each of the " +
                          std::to_string(cameras_->size()) + " cameras");
  }
  for (size_t v = 0; v < frame.views.size(); ++v) {
    std::vector<Observation>& observations = observations_[v];
    size_t count = 0;
    for (const Detection& detection : frame.views[v].detections) {
      if (count == observations.size()) observations.emplace_back();
      MakeObservation(detection, joint_map_, counted_joints_, (*cameras_)[v],
                      static_cast<int>(v), frame.views[v].capture_time,
                      &observations[count]);
      if (observations[count].found_count >= min_found_joints_) ++count;
    }
    counts_[v] =
        suppress_duplicates_ ? SuppressDuplicates(count, &observations) : count;
  }
}

}  // namespace kinegraph
