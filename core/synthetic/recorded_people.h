// People of a scene from tracks files: clips of recorded motion, each with its
// position, direction and time.
#ifndef KINEGRAPH_CORE_SYNTHETIC_RECORDED_PEOPLE_H_
#define KINEGRAPH_CORE_SYNTHETIC_RECORDED_PEOPLE_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/base/options.h"
#include "core/data/pose.h"
#include "core/synthetic/scene.h"
#include "core/synthetic/spline.h"

namespace kinegraph {

// The configuration's table [motion]: recorded people replace simulated ones.
// Lists have one entry per clip, in the order of `clips`; those of start_s and
// hold_s may end early.
struct RecordedPeopleOptions {
  std::vector<std::string> clips;  // tracks files; empty: people are simulated
  std::vector<double> start_s;     // time of appearance; not given: 0
  // Time for which the people of a clip hold its first pose; not given: 0.
  std::vector<double> hold_s;
  // Position of the centre of each clip's path and rotation of the clip about
  // the vertical; empty: drawn from scene.seed.
  std::vector<double> x_m;
  std::vector<double> y_m;
  std::vector<double> turn_deg;
  double hold_sway_m = 0.006;  // RMS sway of a held body, 1 m above the ankles
  // Mean amplitude of the motion of joint centres as joints bend.
  double joint_sway_m = 0.0;

  void Describe(OptionVisitor& visitor);
};

// A tracks file as read.
struct MotionClip {
  std::string name;  // the file
  TrackSequence tracks;
};

// `skeleton` without the joints that a clip lacks: markers, for example, have
// no face. The name then ends in "_part".
Skeleton JointsOfClips(const std::vector<MotionClip>& clips,
                       const Skeleton& skeleton);

// One person of a clip, in the clip's own frame and time (0: the clip's first
// frame).
struct RecordedMotion {
  std::string clip;  // the file, for messages and scene.json
  TrackId id;        // of the person in the file
  Skeleton skeleton;
  // Coordinates of all joints, x y z of the first, then of the next. One piece
  // for each segment without a gap of more than 0.25 s; at least one.
  std::vector<KnotSpline> pieces;
};

// The people of one clip in the joints of `skeleton`, matched by name. A frame
// in which a joint of the person is missing counts as one without the person;
// gaps of up to 0.25 s are bridged. Throws InputError naming the file and the
// problem: no frames, no people, a joint that the file lacks, a position that
// is not finite, times that do not ascend, nobody in two frames at most 0.25 s
// apart.
std::vector<RecordedMotion> MotionsOf(const MotionClip& clip,
                                      const Skeleton& skeleton);

// The room in which clips are placed.
struct ClipRoom {
  double radius_m = 3.0;        // people stay inside if they fit
  double min_distance_m = 0.0;  // between trunks of people of different clips
  uint64_t seed = 1;
};

// After a held pose the clip's time accelerates from rest to its normal rate
// within this time [s], so that people who walk from the first frame on do not
// start abruptly.
inline constexpr double kStartRamp = 0.3;

// All people of all clips. People of one file keep their relative positions.
// Adding a clip at the end does not move earlier ones. Throws InputError as
// MotionsOf does, and OptionError naming the key of the table.
std::vector<std::shared_ptr<const Actor>> MakeRecordedPeople(
    const RecordedPeopleOptions& options, const std::vector<MotionClip>& clips,
    const Skeleton& skeleton, const ClipRoom& room);

// When the last person leaves [s].
double EndOf(const std::vector<std::shared_ptr<const Actor>>& people);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_SYNTHETIC_RECORDED_PEOPLE_H_
