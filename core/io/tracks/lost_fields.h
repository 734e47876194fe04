// What tracks have, and so what a format leaves out. For core/io alone.
#ifndef KINEGRAPH_CORE_IO_TRACKS_LOST_FIELDS_H_
#define KINEGRAPH_CORE_IO_TRACKS_LOST_FIELDS_H_

#include <cstdint>
#include <vector>

#include "core/data/pose.h"
#include "core/io/text/lost_fields.h"

namespace kinegraph {

// What a recording has besides positions.
struct TrackContents {
  bool has_covariances = false;
  bool has_views = false;     // counts of inlier views
  bool has_matches = false;   // matches, weights and scores
  bool has_inferred = false;  // joints with that status
  // Some frame has another time than 0, or the frame rate is known.
  bool has_clock = false;
  int64_t empty_frames = 0;  // nobody in them
};
TrackContents ContentsOf(const TrackSequence& tracks);

inline constexpr const char* kNoClock =
    "times are not known and left out (--frame_rate=HZ)";

// Of each joint of the skeleton, whether anybody has it in some frame.
std::vector<bool> JointsSeen(const TrackSequence& tracks);

// Everybody in the recording, ascending.
std::vector<int64_t> IdsOf(const TrackSequence& tracks);

// That covariances, views and matches are lost, as far as there are any.
void NoteStatistics(const TrackContents& contents, LostFields* lost_fields);
// The same, where the status of joints is lost as well.
void NotePlainPositions(const TrackContents& contents, LostFields* lost_fields);
// That the format wants a place for every joint, and so many were made up
// between others of their own in time.
void NoteFilledJoints(size_t count, LostFields* lost_fields);
// What every format loses that keeps frames, identities and positions alone.
void NotePositionsOnly(const TrackSequence& tracks, LostFields* lost_fields);
// That identities from `first_lost` on, and all others with them, are counted
// anew by the format's readers.
void NoteRenumbering(const TrackSequence& tracks, int64_t first_lost,
                     LostFields* lost_fields);
// That times and frame rate are lost, when there are any.
void NoteClock(const TrackSequence& tracks, LostFields* lost_fields);
// That the file does not tell the skeleton.
void NoteSkeleton(const TrackSequence& tracks, LostFields* lost_fields);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TRACKS_LOST_FIELDS_H_
