// Bounds of the numbers in recordings, as documented in docs/limits.md.
// Readers, constructors and writers share them, so everything written can be
// read.
#ifndef KINEGRAPH_CORE_DATA_LIMITS_H_
#define KINEGRAPH_CORE_DATA_LIMITS_H_

#include <cstdint>
#include <limits>

namespace kinegraph {

inline constexpr int64_t kMaxFrame = int64_t{1} << 50;
inline constexpr int64_t kMaxId = std::numeric_limits<int64_t>::max();
inline constexpr double kMaxFrameRate_hz = 1e6;
// Bound of the absolute value: the difference of two times fits a TimeNs, and
// seconds since 1970 are within it until 2115.
inline constexpr double kMaxTime_s = 4.6e9;

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_DATA_LIMITS_H_
