#include "core/io/track_losses.h"

#include <algorithm>

#include "core/io/bulk_json.h"

namespace kinegraph {

TrackContents ContentsOf(const TrackSequence& tracks) {
  TrackContents contents;
  for (const TrackFrame& frame : tracks.frames) {
    if (frame.people.empty()) ++contents.empty_frames;
    if (frame.time != TimeOfFrame(frame.frame, tracks.header.frame_rate_hz)) {
      contents.has_own_times = true;
    }
    for (const PersonPose& person : frame.people) {
      if (!person.inlier_views.empty()) contents.has_views = true;
      if (!person.matches.empty()) contents.has_matches = true;
      contents.has_covariances =
          contents.has_covariances ||
          std::any_of(person.covariances.begin(), person.covariances.end(),
                      [](const auto& c) { return c.has_value(); });
      contents.has_inferred =
          contents.has_inferred ||
          std::any_of(person.joints.begin(), person.joints.end(),
                      [](const Joint3d& joint) {
                        return joint.status == JointStatus::kInferred;
                      });
    }
  }
  return contents;
}

}  // namespace kinegraph
