// What must hold before tracks are scored against a ground truth.
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

// How frames are paired where that needs saying, and that nobody is found.
// Throws InputError where rates cannot be paired, where other axes or another
// unit would find the people that are not found as the files stand (naming the
// flag), and where nobody is annotated in `frames`, which count as the tracks
// do (none: all).
std::vector<std::string> CheckGroundTruth(
    const ReadRecording& truth, const ReadRecording& tracks,
    const std::vector<FrameRange>& frames);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_GROUND_TRUTH_H_
