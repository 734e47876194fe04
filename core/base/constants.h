// Constants used throughout the project.
#ifndef KINEGRAPH_CORE_BASE_CONSTANTS_H_
#define KINEGRAPH_CORE_BASE_CONSTANTS_H_

#include <limits>

namespace kinegraph {

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kDegPerRad = 180.0 / kPi;
inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

inline constexpr double kCentimetresPerMetre = 100.0;
inline constexpr double kMillimetresPerMetre = 1000.0;
inline constexpr double kMetresPerCentimetre = 0.01;

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_BASE_CONSTANTS_H_
