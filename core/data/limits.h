// Bounds of the numbers in recordings, as docs/limits.md states them. Readers,
// constructors and writers share them: what is written can be read.
#ifndef KINEGRAPH_CORE_DATA_LIMITS_H_
#define KINEGRAPH_CORE_DATA_LIMITS_H_

#include <cstdint>
#include <limits>

namespace kinegraph {

inline constexpr int64_t kMaxFrame = int64_t{1} << 50;
inline constexpr int64_t kMaxId = std::numeric_limits<int64_t>::max();
inline constexpr double kMaxFrameRate_hz = 1e6;
// To either side of zero: differences of two times fit a TimeNs, and the
// seconds since 1970 of the next 90 years do.
inline constexpr double kMaxTime_s = 4.6e9;

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_DATA_LIMITS_H_
