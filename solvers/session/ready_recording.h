// Changes to cameras and clocks before a recording is tracked: the clocks
// recorded in a calibration, refinement (cameras.refine, cameras.refine_clock),
// and the floor (cameras.ground).
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
#include "solvers/cameras/world_motion.h"
#include "solvers/session/ground.h"
#include "solvers/session/options.h"
#include "solvers/session/scene.h"

namespace kinegraph {

// Whether the options request anything that needs the whole recording first.
bool ChangesCameras(const RunOptions& options);

// The time from which WithClocks counts drifts.
double MiddleOf(const DetectionSequence& detections);

// The requested frames with the clocks of a record, as in the run that wrote
// it. Throws as PrepareScene.
DetectionSequence WithRecordedClocks(const RunOptions& options,
                                     const RunRequest& request,
                                     const RefinementRecord& record,
                                     const DetectionSequence& detections);

// The effect of the record's uncertainty on the joints of a run; null if it
// covers none of the run's cameras.
std::unique_ptr<CameraUncertainty> UncertaintyOf(
    const RefinementRecord& record, const RunScene& scene,
    const Skeleton& detection_skeleton);

struct ReadyRecording {
  CameraRig cameras;  // those of the request; refined, on the floor
  // From this refinement, else from the calibration.
  std::optional<RefinementRecord> record;
  std::optional<Refinement> refinement;  // one change per used view
  // By the refined cameras, before the floor; nullopt: none was changed.
  std::optional<WorldMotion> world_motion;
  std::optional<Ground> ground;
  bool misses_ground = false;  // requested, but too few feet rest
  // The requested frames of all views with corrected clocks; nullopt:
  // unchanged.
  std::optional<DetectionSequence> detections;

  bool changes_cameras() const {
    return refinement.has_value() || ground.has_value();
  }
};

// Refines the parameters that the options request, from the matches of one
// tracking run; if clocks are requested, after a search for whole-frame lags.
// Throws as PrepareScene.
ReadyRecording RefineRecording(const RunOptions& options,
                               const RunRequest& request,
                               const DetectionSequence& detections);

// `recorded`: the record of an earlier run in the request's calibration. `read`
// is called if the recording is needed. Throws as PrepareScene, and OptionError
// if refined parameters would be refined again.
ReadyRecording MakeRecordingReady(
    const RunOptions& options, const RunRequest& request,
    const std::optional<RefinementRecord>& recorded,
    const std::function<DetectionSequence()>& read);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SESSION_READY_RECORDING_H_
