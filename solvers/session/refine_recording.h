// Cameras and clocks refined from a recording's own people, before it is
// tracked.
#ifndef KINEGRAPH_SOLVERS_SESSION_REFINE_RECORDING_H_
#define KINEGRAPH_SOLVERS_SESSION_REFINE_RECORDING_H_

#include <memory>
#include <vector>

#include "core/data/detection.h"
#include "core/geometry/camera.h"
#include "core/io/configuration/refinement_record.h"
#include "solvers/cameras/camera_uncertainty.h"
#include "solvers/cameras/refine.h"
#include "solvers/session/options.h"
#include "solvers/session/scene.h"

namespace kinegraph {

struct RefinedRecording {
  Refinement refinement;  // one change a used view
  CameraRig stated;       // cameras of the used views, as given
  CameraRig cameras;      // of the request, the used ones refined
  RefinementRecord record;
  // The frames asked for, with all views and their clocks set right.
  DetectionSequence detections;
};

// Where WithClocks counts drifts from.
double MiddleOf(const DetectionSequence& detections);

// Tracks the recording once to match it, with whole-frame lags of its clocks
// found first where the options ask for clocks, and refines what they ask for.
// Throws as PrepareScene.
RefinedRecording RefineRecording(const RunOptions& options,
                                 const RunRequest& request,
                                 const DetectionSequence& detections);

// The frames asked for with the clocks of a record, as the run that wrote it
// saw them. Throws as PrepareScene.
DetectionSequence WithRecordedClocks(const RunOptions& options,
                                     const RunRequest& request,
                                     const RefinementRecord& record,
                                     const DetectionSequence& detections);

// What the record's uncertainty does to the joints of a run; null when it
// states none of the run's cameras.
std::unique_ptr<CameraUncertainty> UncertaintyOf(
    const RefinementRecord& record, const RunScene& scene,
    const Skeleton& detection_skeleton);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SESSION_REFINE_RECORDING_H_
