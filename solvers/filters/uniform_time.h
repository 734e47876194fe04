// Filters that need samples at equal distances say so.
#ifndef KINEGRAPH_SOLVERS_FILTERS_UNIFORM_TIME_H_
#define KINEGRAPH_SOLVERS_FILTERS_UNIFORM_TIME_H_

#include <string>
#include <vector>

namespace kinegraph {

// Throws InputError naming `estimator` when a step of time is more than half a
// nominal frame longer or shorter than a frame: a frame was dropped, or the
// clock is not that of the frame rate. `times_s` ascend,
// from the track's first frame.
void RequireUniformTime(const std::string& estimator,
                        const std::vector<double>& times_s, double rate_hz);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FILTERS_UNIFORM_TIME_H_
