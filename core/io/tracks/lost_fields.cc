#include "core/io/tracks/lost_fields.h"

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

std::vector<bool> JointsSeen(const TrackSequence& tracks) {
  std::vector<bool> is_seen(tracks.header.skeleton.joints().size(), false);
  for (const TrackFrame& frame : tracks.frames) {
    for (const PersonPose& person : frame.people) {
      for (size_t j = 0; j < is_seen.size(); ++j) {
        if (person.joints[j].present()) is_seen[j] = true;
      }
    }
  }
  return is_seen;
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

void NoteStatistics(const TrackContents& contents, LostFields* lost_fields) {
  if (contents.has_covariances)
    lost_fields->push_back("covariances are not kept");
  if (contents.has_views || contents.has_matches) {
    lost_fields->push_back("counts of views and matches are not kept");
  }
}

void NotePlainPositions(const TrackContents& contents,
                        LostFields* lost_fields) {
  if (contents.has_inferred) {
    lost_fields->push_back("inferred joints are written like observed ones");
  }
  NoteStatistics(contents, lost_fields);
}

void NoteFilledJoints(size_t count, LostFields* lost_fields) {
  if (count == 0) return;
  lost_fields->push_back(
      std::to_string(count) +
      " missing joints got a place between their neighbours in "
      "time");
}

void NotePositionsOnly(const TrackSequence& tracks, LostFields* lost_fields) {
  const TrackContents contents = ContentsOf(tracks);
  lost_fields->push_back(
      "bones, names of joints and configuration are not kept");
  if (contents.has_inferred) {
    lost_fields->push_back("inferred joints read back as observed");
  }
  NoteStatistics(contents, lost_fields);
}

void NoteRenumbering(const TrackSequence& tracks, int64_t first_lost,
                     LostFields* lost_fields) {
  const std::vector<int64_t> ids = IdsOf(tracks);
  if (ids.empty() || ids.back() < first_lost) return;
  lost_fields->push_back(
      "ids of " + std::to_string(first_lost) +
      " and above are too large: people are numbered anew, from "
      "0, when the result is read");
}

void NoteClock(const TrackSequence& tracks, LostFields* lost_fields) {
  if (ContentsOf(tracks).has_clock) {
    lost_fields->push_back(
        "times and frame rate are not kept: name the rate when reading "
        "(--frame_rate=HZ)");
  }
}

void NoteSkeleton(const TrackSequence& tracks, LostFields* lost_fields) {
  lost_fields->push_back("the file does not tell the skeleton '" +
                         tracks.header.skeleton.name() +
                         "': name it when reading (--skeleton)");
}

}  // namespace kinegraph
