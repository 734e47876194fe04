// Lengths of the human body as shares of the stature: Drillis and Contini,
// "Body segment parameters" (1966), as in Winter, "Biomechanics and Motor
// Control of Human Movement", fig. 4.1.
#ifndef KINEGRAPH_CORE_SKELETON_ANTHROPOMETRY_H_
#define KINEGRAPH_CORE_SKELETON_ANTHROPOMETRY_H_

namespace kinegraph {

inline constexpr double kUpperArmShare = 0.186;
inline constexpr double kForearmShare = 0.146;
inline constexpr double kThighShare = 0.245;
inline constexpr double kShankShare = 0.246;
inline constexpr double kAnkleHeightShare = 0.039;
inline constexpr double kFootShare = 0.152;
// From the midpoint of the hips to that of the shoulders.
inline constexpr double kTrunkShare = 0.288;
inline constexpr double kHalfShoulderShare = 0.129;
// From ankle to shoulder of a standing person: 0.818 - 0.039.
inline constexpr double kAnkleToShoulderShare = 0.779;

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_SKELETON_ANTHROPOMETRY_H_
