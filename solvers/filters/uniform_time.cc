#include "solvers/filters/uniform_time.h"

#include <cmath>
#include <cstddef>
#include <cstdio>

#include "core/base/error.h"

namespace kinegraph {

void RequireUniformTime(const std::string& estimator,
                        const std::vector<double>& times_s, double rate_hz) {
  // Frame times are rounded to nanoseconds.
  constexpr double kSlack_s = 1e-6;
  for (size_t k = 1; k < times_s.size(); ++k) {
    const double step_s = times_s[k] - times_s[k - 1];
    if (std::abs(step_s - 1.0 / rate_hz) <= 0.5 / rate_hz + kSlack_s) continue;
    char text[160];
    std::snprintf(text, sizeof(text),
                  "needs uniform time, found a step of %.4f s, %.4f s into the "
                  "track, where a frame is %.4f s (allowed: half a frame more "
                  "or less)",
                  step_s, times_s[k - 1], 1.0 / rate_hz);
    throw InputError("output.estimator '" + estimator + "' " + text);
  }
}

}  // namespace kinegraph
