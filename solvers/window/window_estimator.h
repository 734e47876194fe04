// The newest frames in a sliding window: final after a fixed lag.
#ifndef KINEGRAPH_SOLVERS_WINDOW_WINDOW_ESTIMATOR_H_
#define KINEGRAPH_SOLVERS_WINDOW_WINDOW_ESTIMATOR_H_

#include <memory>

#include "core/tracking/estimator.h"
#include "solvers/graph/options.h"
#include "solvers/noise/recording_notes.h"

namespace kinegraph {

// Every Add solves the window anew, with the whole convexity schedule; where
// frames come faster than 60 a second every second, third, ... does. A frame
// that is graph.lag_s older than the newest, or is so before the next solve,
// becomes final, and is marginalised
// into a prior on its successor when the next frame comes. Memory does not grow
// with the length of the track. Last() is the estimate at the newest frame
// that was solved and in which a view measured anything. Throws OptionError for
// bad options. `notes` are shared with the run's other people; null: notes of
// its own.
std::unique_ptr<Estimator> MakeWindowEstimator(
    const SceneModel& scene, const GraphOptions& options,
    std::shared_ptr<RecordingNotes> notes = nullptr);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_WINDOW_WINDOW_ESTIMATOR_H_
