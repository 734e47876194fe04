// Time is an int64 number of nanoseconds. Where constants are in frames, as
// those of Chu et al. (2021), durations are converted to frames at the nominal
// rate.
#ifndef KINEGRAPH_CORE_BASE_TIME_H_
#define KINEGRAPH_CORE_BASE_TIME_H_

#include <cmath>
#include <cstdint>

namespace kinegraph {

using TimeNs = int64_t;

inline constexpr double kNanosecondsPerSecond = 1e9;

inline double ToSeconds(TimeNs duration_ns) {
  return static_cast<double>(duration_ns) / kNanosecondsPerSecond;
}

inline TimeNs FromSeconds(double seconds) {
  return static_cast<TimeNs>(std::llround(seconds * kNanosecondsPerSecond));
}

// Converts between frames and time at a recording's nominal rate. Durations are
// compared with half a frame of tolerance, so that the result depends neither
// on rounding nor on jitter (without it, at 29.97 Hz, times in whole
// nanoseconds make an age of exactly 3 frames less than 3 in nine of ten
// frames).
class FrameClock {
 public:
  // `frame_rate_hz` > 0.
  explicit FrameClock(double frame_rate_hz) : frame_rate_hz_(frame_rate_hz) {}

  double frame_rate_hz() const { return frame_rate_hz_; }
  // Time of frame `frame` in recordings without times [ns].
  TimeNs TimeOf(int64_t frame) const {
    return FromSeconds(static_cast<double>(frame) / frame_rate_hz_);
  }
  // A duration in (fractional) frames.
  double Frames(TimeNs duration_ns) const {
    return ToSeconds(duration_ns) * frame_rate_hz_;
  }
  // duration < limit, in frames, with half a frame of tolerance.
  bool Less(TimeNs duration_ns, double limit_frames) const {
    return Frames(duration_ns) < limit_frames - 0.5;
  }

 private:
  double frame_rate_hz_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_BASE_TIME_H_
