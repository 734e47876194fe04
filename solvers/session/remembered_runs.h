// Runs whose dear parts are kept in a checkpoint
// (core/io/configuration/checkpoint.h): what stands there is not computed
// again.
#ifndef KINEGRAPH_SOLVERS_SESSION_REMEMBERED_RUNS_H_
#define KINEGRAPH_SOLVERS_SESSION_REMEMBERED_RUNS_H_

#include <string>

#include "core/io/configuration/checkpoint.h"
#include "solvers/factory.h"
#include "solvers/session/run.h"

namespace kinegraph {

// As MakeEstimators. What a batch solves when somebody's track ends is kept
// person by person, with its counts; the key is all that the person's estimator
// was given. Other estimators answer frame by frame and are run again.
// `checkpoint` must outlive the estimators.
EstimatorPair MakeRememberedEstimators(const EstimatorOptions& options,
                                       const std::string& config_json,
                                       Checkpoint* checkpoint);

// TrackSequenceOf, or what the checkpoint has of it: all tracks as a whole.
// Null: nothing is kept.
TrackSequence RememberedTracks(const RunOptions& options,
                               const RunRequest& request,
                               const DetectionSequence& detections,
                               Checkpoint* checkpoint);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SESSION_REMEMBERED_RUNS_H_
