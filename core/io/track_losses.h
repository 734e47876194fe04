// What formats leave out of tracks. For core/io alone.
#ifndef KINEGRAPH_CORE_IO_TRACK_LOSSES_H_
#define KINEGRAPH_CORE_IO_TRACK_LOSSES_H_

#include <cstdint>

#include "core/data/pose.h"

namespace kinegraph {

// What a take has besides positions.
struct TrackContents {
  bool has_covariances = false;
  bool has_views = false;      // counts of inlier views
  bool has_matches = false;    // matches, weights and scores
  bool has_inferred = false;   // joints with that status
  bool has_own_times = false;  // other than frame / frame rate
  int64_t empty_frames = 0;    // nobody in them
};
TrackContents ContentsOf(const TrackSequence& tracks);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TRACK_LOSSES_H_
