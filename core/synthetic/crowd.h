// Paths of a crowd: several people walk, stop, turn, sit and pass each other on
// a round area. The simulation runs before anything is sampled; its
// trajectories are smoothed and can be evaluated at any time.
#ifndef KINEGRAPH_CORE_SYNTHETIC_CROWD_H_
#define KINEGRAPH_CORE_SYNTHETIC_CROWD_H_

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/synthetic/scene.h"
#include "core/synthetic/spline.h"

namespace kinegraph {

// The unit vector at this angle from x.
inline Eigen::Vector2d Direction(double angle_rad) {
  return {std::cos(angle_rad), std::sin(angle_rad)};
}

enum class GestureKind { kRaise, kWave, kReach, kPhone, kHandOnHip };
inline constexpr int kGestureKindCount = 5;

struct Gesture {
  TimeSpan span;
  int side = 0;
  GestureKind kind = GestureKind::kRaise;
};

// Plan of one person.
struct Itinerary {
  UniformSpline path;             // x [m], y [m], heading [rad, unwrapped]
  std::vector<TimeSpan> present;  // when the person is in the scene
  // From the start of sitting down until standing again.
  std::vector<TimeSpan> seated;
  std::vector<Gesture> gestures;
};

// Duration of sitting down, and of standing up again [s].
inline constexpr double kSitDownTime = 1.6;
// Distance that the pelvis moves back onto the seat [m].
inline constexpr double kSeatDistance = 0.38;
// How far outside the area people appear and disappear [m].
inline constexpr double kOuterMargin = 0.8;

// One plan per person, for all of `span`. Same seed, same plans.
std::vector<Itinerary> SimulateCrowd(const CrowdOptions& options, int people,
                                     TimeSpan span, uint64_t seed);

// People who follow such plans: they walk, swing their arms, sit and gesture.
// Throws OptionError("skeleton", ...) for joints that a body does not have.
std::vector<std::shared_ptr<const Actor>> SimulatePeople(
    const SceneOptions& options, const Skeleton& skeleton);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_SYNTHETIC_CROWD_H_
