// Estimates a whole recording at once: the offline reference for the window.
#ifndef KINEGRAPH_SOLVERS_BATCH_BATCH_ESTIMATOR_H_
#define KINEGRAPH_SOLVERS_BATCH_BATCH_ESTIMATOR_H_

#include <memory>

#include "core/tracking/estimator.h"
#include "solvers/graph/options.h"
#include "solvers/noise/recording_notes.h"

namespace kinegraph {

// Collects frames and solves in Finish(), which makes every pose final. There
// is no causal estimate: Last() is the newest initial pose and Predict()
// returns the same positions as inferred joints, so the estimator should not be
// used for association. Throws OptionError for bad options. `notes` are shared
// with the other people of the run; null: separate notes.
std::unique_ptr<Estimator> MakeBatchEstimator(
    const SceneModel& scene, const GraphOptions& options,
    std::shared_ptr<RecordingNotes> notes = nullptr);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_BATCH_BATCH_ESTIMATOR_H_
