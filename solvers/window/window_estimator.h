// Estimator over a sliding window of the newest frames: final after a fixed
// lag.
#ifndef KINEGRAPH_SOLVERS_WINDOW_WINDOW_ESTIMATOR_H_
#define KINEGRAPH_SOLVERS_WINDOW_WINDOW_ESTIMATOR_H_

#include <memory>

#include "core/tracking/estimator.h"
#include "solvers/graph/options.h"
#include "solvers/noise/recording_notes.h"

namespace kinegraph {

// Add runs the whole schedule (MakeSchedule) on the window: every Add below 120
// frames per second, every second, third, ... above, at least 60 times per
// second and once per graph.lag_s. A frame becomes final when it is
// graph.lag_s older than the newest, or will be before the next solve; it is
// marginalised into a prior on its successor when the next frame arrives.
// Memory does not grow with the length of the track. Last() is the estimate at
// the newest solved frame in which a view was matched. Throws OptionError for
// bad options. `notes` are shared with the other people of the run; null:
// separate notes.
std::unique_ptr<Estimator> MakeWindowEstimator(
    const SceneModel& scene, const GraphOptions& options,
    std::shared_ptr<RecordingNotes> notes = nullptr);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_WINDOW_WINDOW_ESTIMATOR_H_
