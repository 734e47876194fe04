// The worst moments of a recording.
#ifndef KINEGRAPH_APPS_REPORT_MOMENTS_H_
#define KINEGRAPH_APPS_REPORT_MOMENTS_H_

#include <cstdint>
#include <string>
#include <vector>

#include "core/data/pose.h"

namespace kinegraph {

enum class MomentKind {
  kResidual,    // px, the worst view's mean
  kSpeedJump,   // m/s, between two steps of a joint
  kBone,        // m, from the bone's median of that person
  kDifference,  // m, mean joint distance to truth, or to the other result
  kStart,       // an identity appears after the first frame
  kEnd,         // an identity is gone before the last frame
};
const char* ToString(MomentKind kind);

struct Moment {
  MomentKind kind = MomentKind::kResidual;
  int64_t frame = 0;
  TimeNs time = 0;
  TrackId id;
  double value = 0.0;
  std::string detail;  // the joint, bone or view
};

// The largest of one kind, the worst first; of one person at most one within
// half a second.
std::vector<Moment> Largest(std::vector<Moment> moments, size_t count);

// Each joint's change of velocity, each bone's deviation, starts and ends.
std::vector<Moment> SpeedJumps(const TrackSequence& tracks);
std::vector<Moment> BoneDeviations(const TrackSequence& tracks);
std::vector<Moment> StartsAndEnds(const TrackSequence& tracks);

// Mean distance over shared joints to the nearest person of the other result;
// people farther apart than a metre are not compared. [frame][person], negative
// where there is none.
std::vector<std::vector<double>> DifferencesTo(const TrackSequence& other,
                                               const TrackSequence& tracks);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_REPORT_MOMENTS_H_
