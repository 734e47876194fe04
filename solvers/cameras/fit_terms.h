// What several fits of cameras and clocks have in common.
#ifndef KINEGRAPH_SOLVERS_CAMERAS_FIT_TERMS_H_
#define KINEGRAPH_SOLVERS_CAMERAS_FIT_TERMS_H_

#include "solvers/cameras/camera_change.h"

namespace kinegraph {

// Information on a stretch's position that keeps its normal equations regular
// where its views leave a direction open: that of a kilometre [1/m^2].
inline constexpr double kPositionInformation = 1e-6;

// A stretch is a fifth of a second long. Of a clock that is off by more than
// half of it it tells nothing: beyond its ends its speed and acceleration
// follow a view's noise. Whole frames are looked for before.
inline constexpr double kFarthestClockS = 0.1;

// A clock as it can be told from a recording of this length: its offset, and
// its drift where 100 ppm of it are two milliseconds.
inline FreeParameters ClockParametersOf(double span_s) {
  constexpr double kDriftSpanS = 20.0;
  FreeParameters clock;
  clock.offset = true;
  clock.drift = span_s > kDriftSpanS;
  return clock;
}

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_CAMERAS_FIT_TERMS_H_
