// The worst moments (instants) of a recording.
#ifndef KINEGRAPH_APPS_REPORT_MOMENTS_H_
#define KINEGRAPH_APPS_REPORT_MOMENTS_H_

#include <cstdint>
#include <string>
#include <vector>

#include "core/data/pose.h"

namespace kinegraph {

enum class MomentKind {
  kResidual,    // px, the worst view's mean
  kSpeedJump,   // m/s, change of a joint's velocity from one step to the next
  kBone,        // m, deviation from the median length of the person's bone
  kDifference,  // m, mean joint distance from the truth or another result
  kStart,       // an identity appears after the first frame
  kEnd,         // an identity ends before the last frame
};
const char* ToString(MomentKind kind);

struct Moment {
  MomentKind kind = MomentKind::kResidual;
  int64_t frame = 0;
  TimeNs time = 0;
  TrackId id;
  double value = 0.0;
  std::string detail;  // the joint, bone or view; empty for other kinds
};

// Selects at most `count` outliers of `moments`, which are of one kind: the
// largest first, and at most one per person within half a second. The threshold
// is the upper quartile plus three times the interquartile range (Tukey 1977,
// "far out"), so that values that are large throughout are not outliers. One in
// 850,000 normally distributed values exceeds it.
std::vector<Moment> Largest(std::vector<Moment> moments, size_t count);

// At most one moment per person and frame: the largest change of a joint's
// velocity, or the largest deviation of a bone's length.
std::vector<Moment> SpeedJumps(const TrackSequence& tracks);
std::vector<Moment> BoneDeviations(const TrackSequence& tracks);
// The frames in which identities start after the first frame or end before the
// last one.
std::vector<Moment> StartsAndEnds(const TrackSequence& tracks);

// Mean distance over shared joints to the nearest person of the other result;
// people farther apart than a metre are not compared. [frame][person], negative
// if there is none.
std::vector<std::vector<double>> DifferencesTo(const TrackSequence& other,
                                               const TrackSequence& tracks);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_REPORT_MOMENTS_H_
