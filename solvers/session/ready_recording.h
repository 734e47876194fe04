// What happens to cameras and clocks before a recording is tracked: the clocks
// that a calibration records, refinement (cameras.refine,
// cameras.refine_clock), and the floor (cameras.ground).
#ifndef KINEGRAPH_SOLVERS_SESSION_READY_RECORDING_H_
#define KINEGRAPH_SOLVERS_SESSION_READY_RECORDING_H_

#include <functional>
#include <memory>
#include <optional>

#include "core/data/detection.h"
#include "core/geometry/camera.h"
#include "core/io/configuration/refinement_record.h"
#include "solvers/cameras/camera_uncertainty.h"
#include "solvers/cameras/refine.h"
#include "solvers/session/ground.h"
#include "solvers/session/options.h"
#include "solvers/session/scene.h"

namespace kinegraph {

// Whether the options ask for anything that needs the whole recording first.
bool ChangesCameras(const RunOptions& options);

// Where WithClocks counts drifts from.
double MiddleOf(const DetectionSequence& detections);

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

struct ReadyRecording {
  CameraRig cameras;  // of the request; refined, on their floor
  // Of this refinement, else of the calibration.
  std::optional<RefinementRecord> record;
  std::optional<Refinement> refinement;  // one change a used view
  std::optional<Ground> ground;
  bool misses_ground = false;  // asked for, and too few feet rest
  // The frames asked for, of all views, with their clocks set right; nullopt:
  // as they are.
  std::optional<DetectionSequence> detections;

  bool changes_cameras() const {
    return refinement.has_value() || ground.has_value();
  }
};

// Tracks the recording once to match it, with whole-frame lags of its clocks
// found first where the options ask for clocks, and refines what they ask for.
// Throws as PrepareScene.
ReadyRecording RefineRecording(const RunOptions& options,
                               const RunRequest& request,
                               const DetectionSequence& detections);

// `recorded`: what the request's calibration says of an earlier run. `read` is
// called where the recording is needed. Throws as PrepareScene, and OptionError
// when what is refined already is to be refined again.
ReadyRecording MakeRecordingReady(
    const RunOptions& options, const RunRequest& request,
    const std::optional<RefinementRecord>& recorded,
    const std::function<DetectionSequence()>& read);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SESSION_READY_RECORDING_H_
