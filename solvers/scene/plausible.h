// What is plausible of people, cameras and recordings, once for all that judge
// a set-up. None was fitted to a score.
#ifndef KINEGRAPH_SOLVERS_SCENE_PLAUSIBLE_H_
#define KINEGRAPH_SOLVERS_SCENE_PLAUSIBLE_H_

#include <cmath>
#include <cstdint>

namespace kinegraph {

// Of the joints that are looked at; detectors whose confidences are small
// throughout are scaled first (WithUsualConfidences).
inline constexpr double kMinJointConfidence = 0.3;

// Statures of people of all ages: infants to basketball players [m].
inline constexpr double kMinHeight = 0.5;
inline constexpr double kMaxHeight = 2.3;
// Statures that a median is taken of, and frames in which they are looked for.
inline constexpr int kEnoughStatures = 20;
inline constexpr int kFramesToLookAt = 40;

// From cameras to people: a desk, a stadium; to what is no human a microscope
// [m].
inline constexpr double kMinDistance = 0.5;
inline constexpr double kMaxDistance = 150.0;
inline constexpr double kNearest = 0.005;

// Of the middle of the hips, 95 % of the time [m/s]; sprinters reach 10.
inline constexpr double kMaxBodySpeed = 8.0;

// Between two frames that anybody can be followed over [s]: beyond the first
// somebody walks on past the gates, beyond the second nothing is motion.
inline constexpr double kHole = 0.4;
inline constexpr double kLongestGapS = 1.0;

// Clocks of cameras that somebody started by hand [s].
inline constexpr double kLongestLagS = 10.0;

// Detections of a view that may show people.
inline constexpr int kEnoughDetections = 20;

// Whether a view is a stranger: fewer than a fifth of its detections are
// matched, and so few that of one that is matched by halves it happens once in
// a hundred recordings.
inline bool HardlyAny(int64_t matched, int64_t all) {
  constexpr double kShare = 0.2;
  constexpr double kChance = 0.01;
  if (static_cast<double>(matched) > kShare * static_cast<double>(all)) {
    return false;
  }
  // Beyond so many a fifth is rarer than that.
  constexpr int64_t kMany = 60;
  if (all >= kMany) return true;
  double ways = std::pow(0.5, static_cast<double>(all));
  double chance = 0.0;
  for (int64_t k = 0; k <= matched; ++k) {
    chance += ways;
    ways *= static_cast<double>(all - k) / static_cast<double>(k + 1);
  }
  return chance <= kChance;
}

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SCENE_PLAUSIBLE_H_
