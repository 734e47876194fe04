// Runs that are kept in a checkpoint (core/io/configuration/checkpoint.h): what
// stands there is not computed again.
#ifndef KINEGRAPH_SOLVERS_SESSION_REMEMBERED_RUNS_H_
#define KINEGRAPH_SOLVERS_SESSION_REMEMBERED_RUNS_H_

#include "core/io/configuration/checkpoint.h"
#include "solvers/session/run.h"

namespace kinegraph {

// TrackSequenceOf, or what the checkpoint has of it: all tracks as a whole, and
// while they are made, what the batch has solved (GraphOptions::pieces). Null:
// nothing is kept.
TrackSequence RememberedTracks(const RunOptions& options,
                               const RunRequest& request,
                               const DetectionSequence& detections,
                               Checkpoint* checkpoint);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SESSION_REMEMBERED_RUNS_H_
