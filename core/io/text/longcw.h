// Shared by the readers and writers of the detections and poses of longcw's
// crossview data.
#ifndef KINEGRAPH_CORE_IO_TEXT_LONGCW_H_
#define KINEGRAPH_CORE_IO_TEXT_LONGCW_H_

#include <cmath>
#include <cstdint>
#include <string>

#include "core/data/limits.h"
#include "core/io/text/bulk_json.h"

namespace kinegraph {

// The default rate for converting the files' times to frame numbers: that of
// Campus, the data set in this format.
inline constexpr double kLongcwFrameRateHz = 25.0;

struct LongcwTime {
  int64_t frame = 0;
  TimeNs time = 0;
};

// The frame nearest to a timestamp. Its InputError does not name the file.
inline LongcwTime ReadLongcwTime(JsonValue value, double frame_rate_hz) {
  const TimeNs time = AsTime(value, "timestamp");
  const double frame = std::round(ToSeconds(time) * frame_rate_hz);
  if (frame < 0.0 || frame > static_cast<double>(kMaxFrame)) {
    throw InputError("timestamp: is negative or too large");
  }
  return {static_cast<int64_t>(frame), time};
}

// Call these before writing, since the files have times but no frame numbers.
// Throw InputError if there is no frame rate, or if a frame would be read back
// as another frame.
inline void RequireLongcwRate(double frame_rate_hz) {
  if (frame_rate_hz > 0.0) return;
  throw InputError(
      "longcw's files require a frame rate to convert times, which the "
      "input does not specify (--frame_rate=HZ)");
}
inline void RequireLongcwTime(int64_t frame, TimeNs time,
                              double frame_rate_hz) {
  const double read = std::round(ToSeconds(time) * frame_rate_hz);
  if (time >= 0 && read == static_cast<double>(frame)) return;
  throw InputError("frame " + std::to_string(frame) +
                   ": longcw's files have no frame numbers, and this frame "
                   "would be read as another one because of its time");
}

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TEXT_LONGCW_H_
