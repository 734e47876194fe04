// The detector's noise and the motion's process noise, as learnt from a
// recording.
#ifndef KINEGRAPH_SOLVERS_NOISE_LEARNT_NOISE_H_
#define KINEGRAPH_SOLVERS_NOISE_LEARNT_NOISE_H_

#include <array>
#include <cstdint>
#include <string>

#include "core/skeleton/skeleton.h"

namespace kinegraph {

// Correlation of a detector's errors over time: share * exp(-|dt| / time_s) for
// dt != 0; the rest of the variance is white.
struct ErrorCorrelation {
  double share = 0.0;  // 0 .. 1
  double time_s = 0.1;
};

// The learnt values, in physical units.
struct LearntNoise {
  struct OfClass {
    // Number of joints, summed over frames, from which the detector's error was
    // learnt; 0 if nothing was learnt for this class.
    int64_t joints_seen = 0;
    // Error at a confidence of 1, at 4 m with a focal length of 1000 px [px].
    double sigma_px = 0.0;
    // Power of the white noise on acceleration [m^2/s^3], the level of the
    // whole recording.
    double process_noise = 0.0;
    // Least and greatest power of any frame interval so far.
    double least_process_noise = 0.0;
    double greatest_process_noise = 0.0;
  };
  std::array<OfClass, kJointClassCount> classes;
  ErrorCorrelation correlation;
  // The errors grow with confidence^-power.
  double confidence_power = 0.0;
};

// One line for the log: "errors are correlated over 0.1 s (share 0.9), grow
// with confidence^-0.5; wrist 3.1 px, 4.2 (0.4 .. 96) m^2/s^3; ...".
std::string ToString(const LearntNoise& learnt);

// {"error_time_s", "error_share", "confidence_power", "classes": {"wrist":
// {"joints_seen", "sigma_px", "process_noise", "least_process_noise",
// "greatest_process_noise"}, ...}}: the classes with observations, units as in
// LearntNoise.
std::string ToJson(const LearntNoise& learnt);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_NOISE_LEARNT_NOISE_H_
