#include "core/io/track_losses.h"

#include <algorithm>

namespace kinegraph {

TrackContents ContentsOf(const TrackSequence& tracks) {
  TrackContents contents;
  contents.has_clock = tracks.header.frame_rate_hz > 0.0;
  for (const TrackFrame& frame : tracks.frames) {
    if (frame.people.empty()) ++contents.empty_frames;
    if (frame.time != 0) contents.has_clock = true;
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

std::vector<int64_t> IdsOf(const TrackSequence& tracks) {
  std::vector<int64_t> ids;
  for (const TrackFrame& frame : tracks.frames) {
    for (const PersonPose& person : frame.people) {
      ids.push_back(person.id.value());
    }
  }
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  return ids;
}

}  // namespace kinegraph
