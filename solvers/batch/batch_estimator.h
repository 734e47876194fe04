// The whole sequence at once: the offline reference and the window's oracle.
#ifndef KINEGRAPH_SOLVERS_BATCH_BATCH_ESTIMATOR_H_
#define KINEGRAPH_SOLVERS_BATCH_BATCH_ESTIMATOR_H_

#include <memory>

#include "core/tracking/estimator.h"
#include "solvers/graph/options.h"
#include "solvers/noise/recording_notes.h"

namespace kinegraph {

// Collects frames and solves in Finish(); every final pose comes then. As it
// has no causal estimate, Last() is the newest initial pose and Predict() holds
// it: not meant to serve association. Throws OptionError for bad options.
// `notes` are shared with the run's other people; null: notes of its own.
std::unique_ptr<Estimator> MakeBatchEstimator(
    const SceneModel& scene, const GraphOptions& options,
    std::shared_ptr<RecordingNotes> notes = nullptr);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_BATCH_BATCH_ESTIMATOR_H_
