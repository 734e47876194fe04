// Pictures of a study against markers.
#ifndef KINEGRAPH_APPS_MARKERS_MARKER_PLOTS_H_
#define KINEGRAPH_APPS_MARKERS_MARKER_PLOTS_H_

#include <string>
#include <vector>

#include "apps/markers/marker_study.h"

namespace kinegraph {

// bland_altman.svg, errors.svg and, with covariances, calibration.svg into a
// folder that ends with '/'; the names of those written.
std::vector<std::string> WriteMarkerPlots(const MarkerStudy& study,
                                          const std::string& folder);

// The truth's joints with all of its markers behind them, in the frames that
// are scored.
TrackSequence WithMarkers(const MarkerStudy& study);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_MARKERS_MARKER_PLOTS_H_
