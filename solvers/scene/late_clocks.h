// Which views a fit of the clocks finds to be out of time.
#ifndef KINEGRAPH_SOLVERS_SCENE_LATE_CLOCKS_H_
#define KINEGRAPH_SOLVERS_SCENE_LATE_CLOCKS_H_

#include <cstddef>
#include <vector>

#include "solvers/scene/bundle.h"

namespace kinegraph {

// The first view's clock is the reference of a fit, which does not make it
// right: views are late against the median of all.
double UsualClock(const std::vector<CameraChange>& changes, int place);

// Whether the view's offset or drift (`place`) is off by more than four of its
// standard deviations and more than 0.15 frames, over a recording of `span_s`
// for the drift, and less than stretches tell (kFarthestClockS). `fit` has the
// clocks free and no camera.
bool IsLate(const BundleResult& fit, size_t view, int place, double frame_s,
            double span_s);

// Whether any view's offset or drift is.
bool AnyIsLate(const BundleResult& fit, double frame_s, double span_s);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SCENE_LATE_CLOCKS_H_
