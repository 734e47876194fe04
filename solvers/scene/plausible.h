// Plausible ranges of people, cameras and recordings, used by all checks of a
// set-up. None was tuned on a benchmark.
#ifndef KINEGRAPH_SOLVERS_SCENE_PLAUSIBLE_H_
#define KINEGRAPH_SOLVERS_SCENE_PLAUSIBLE_H_

#include <cmath>
#include <cstdint>

namespace kinegraph {

// Minimum confidence of an examined joint; confidences of detectors whose
// values are generally low are rescaled first (WithUsualConfidences).
inline constexpr double kMinJointConfidence = 0.3;

// Statures of people of all ages: infants to basketball players [m].
inline constexpr double kMinHeight = 0.5;
inline constexpr double kMaxHeight = 2.3;
inline bool IsStature(double height_m) {
  return height_m >= kMinHeight && height_m <= kMaxHeight;
}
inline constexpr int kEnoughStatures = 20;  // required for a median

// Number of frames in which statures and the agreement of views are examined.
inline constexpr int kFramesToLookAt = 40;

// Distance from cameras to people [m]: from a desk to a stadium. kNearest is
// the minimum for non-human subjects, e.g. under a microscope.
inline constexpr double kMinDistance = 0.5;
inline constexpr double kMaxDistance = 150.0;
inline constexpr double kNearest = 0.005;
inline bool IsWorkingDistance(double distance_m) {
  return distance_m >= kMinDistance && distance_m <= kMaxDistance;
}

// Speed of a person's mid-hip [m/s]: the fastest sprint measured reached 12.4
// (Graubner and Nixdorf 2011, Berlin 2009). Animals may be faster.
inline constexpr double kMaxBodySpeed = 12.5;

// Longest interval between two frames over which people can be followed [s]:
// beyond kHole, people may leave the region in which the tracker searches for
// them; beyond kLongestGapS, motion is not continuous.
inline constexpr double kHole = 0.4;
inline constexpr double kLongestGapS = 1.0;

// Largest lag between cameras started by hand [s].
inline constexpr double kLongestLagS = 10.0;

// Number of detections needed to judge a view.
inline constexpr int kEnoughDetections = 20;

// Whether a view has practically no matches: at most a fifth of its detections
// are matched, and that few or fewer would have a probability of at most 1 % if
// each detection were matched with probability 1/2.
inline bool HardlyAny(int64_t matched, int64_t all) {
  constexpr double kShare = 0.2;
  constexpr double kChance = 0.01;
  if (static_cast<double>(matched) > kShare * static_cast<double>(all)) {
    return false;
  }
  // From this number on, the probability of a fifth or less is far below
  // kChance and need not be computed.
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
