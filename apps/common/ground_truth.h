// Checks whether tracks and a ground truth can be compared, before scoring.
#ifndef KINEGRAPH_APPS_COMMON_GROUND_TRUTH_H_
#define KINEGRAPH_APPS_COMMON_GROUND_TRUTH_H_

#include <string>
#include <vector>

#include "core/base/frame_range.h"
#include "core/data/pose.h"
#include "core/io/tracks/tracks.h"

namespace kinegraph {

// A recording and how it was read.
struct ReadRecording {
  std::string path;  // empty: a run's own tracks
  TrackReadOptions options;
  const TrackSequence* tracks = nullptr;
};

// Returns notes on the pairing of frames, on people that were not found and on
// subjects too small or too large for kPersonGateM, the distance within which a
// track may be matched with a true person.
// Throws InputError if the frame rates do not allow pairing, if people are
// found only with other axes or another unit (with advice), and if no person is
// annotated in `frames` (numbered as in the tracks; empty: all).
std::vector<std::string> CheckGroundTruth(
    const ReadRecording& truth, const ReadRecording& tracks,
    const std::vector<FrameRange>& frames);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_GROUND_TRUTH_H_
