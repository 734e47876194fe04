// Runs the doctor (solvers/scene/doctor.h) on the input of a run.
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

class SkeletonFit;

// Examines the requested frames (for the order of the joints, all frames). The
// tracker runs with the options' association and the estimator of FeedbackOf.
// `unit`: how the lengths of the request's cameras were read. `recorded`: the
// clocks and covariance recorded with these cameras, applied as in a run.
// Throws what PrepareScene throws.
Diagnosis DiagnoseRecording(
    const RunOptions& options, const RunRequest& request,
    const DetectionSequence& detections, const CalibrationUnit& unit,
    const std::optional<RefinementRecord>& recorded = std::nullopt);

// `own`, then all built-in skeletons with as many joints but other names or
// another order.
std::vector<const Skeleton*> SkeletonsLike(const Skeleton& own);

// `skeletons`: the candidates of `fit`, in their order. A finding if another
// skeleton fits the bone lengths clearly better than the first, or, with
// confidence 0, if none does and the lengths are implausible with the first.
std::optional<Finding> FindingOfSkeleton(
    const SkeletonFit& fit, const std::vector<const Skeleton*>& skeletons);

// Tracks detections of the scene's views with its cameras, in one pass with the
// estimator of FeedbackOf, and freezes the matches (core/tracking/replay.h).
FrozenMatches MatchRecording(const RunOptions& options, const SceneModel& scene,
                             const DetectionSequence& detections);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SESSION_DIAGNOSE_H_
