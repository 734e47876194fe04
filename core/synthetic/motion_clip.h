// Recorded motion of people, from tracks files, as splines.
#ifndef KINEGRAPH_CORE_SYNTHETIC_MOTION_CLIP_H_
#define KINEGRAPH_CORE_SYNTHETIC_MOTION_CLIP_H_

#include <string>
#include <vector>

#include "core/data/pose.h"
#include "core/synthetic/spline.h"

namespace kinegraph {

// A tracks file as it was read.
struct MotionClip {
  std::string name;  // the file
  TrackSequence tracks;
};

// One person of a clip, in the clip's own frame and time (0: the clip's first
// frame).
struct RecordedMotion {
  std::string clip;  // the file, for messages and scene.json
  TrackId id;        // the person's in it
  Skeleton skeleton;
  // Coordinates of all joints, x y z of the first, then of the next. One piece
  // for each stretch without a gap; at least one.
  std::vector<KnotSpline> pieces;
};

// The people of one clip in the joints of `skeleton`, matched by name. Throws
// InputError naming the file and what is wrong: no people, a joint that the
// file does not have, a position that is missing or not finite, times that do
// not ascend, fewer than two frames.
std::vector<RecordedMotion> MotionsOf(const MotionClip& clip,
                                      const Skeleton& skeleton);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_SYNTHETIC_MOTION_CLIP_H_
