// The doctor (solvers/scene/doctor.h) on what a run would be given.
#ifndef KINEGRAPH_SOLVERS_SESSION_DIAGNOSE_H_
#define KINEGRAPH_SOLVERS_SESSION_DIAGNOSE_H_

#include <optional>
#include <vector>

#include "core/data/detection.h"
#include "core/io/calibration/calibration.h"
#include "core/io/configuration/refinement_record.h"
#include "solvers/scene/doctor.h"
#include "solvers/session/options.h"
#include "solvers/session/scene.h"

namespace kinegraph {

// Looks at the frames that the request asks for. The tracker runs with the
// options' front end and the paper's estimator, whatever the mode. `recorded`:
// the clocks and the covariance beside the request's cameras, which count as in
// a run. Throws as PrepareScene.
Diagnosis DiagnoseRecording(
    const RunOptions& options, const RunRequest& request,
    const DetectionSequence& detections, const CalibrationUnit& unit,
    const std::optional<RefinementRecord>& recorded = std::nullopt);

// The skeleton of some detections, then others with as many joints, in another
// order.
std::vector<const Skeleton*> SkeletonsLike(const Skeleton& own);

// Tracks detections of the scene's views with its cameras, once, and freezes
// the matches; one pass, the paper's estimator.
FrozenMatches MatchRecording(const RunOptions& options, const SceneModel& scene,
                             const DetectionSequence& detections);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SESSION_DIAGNOSE_H_
