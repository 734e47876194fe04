// Changes to cameras and clocks before a recording is tracked: the clocks
// recorded in a calibration, refinement (cameras.refine, cameras.refine_clock),
// and the transformation to the floor (cameras.ground).
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

// Whether the options request changes that require the whole recording before
// tracking.
bool ChangesCameras(const RunOptions& options);

// The time of the middle of the recording [s], relative to which WithClocks
// applies drifts; 0 without frames.
double MiddleOf(const DetectionSequence& detections);

// The requested frames with the clocks of a record, as in the run that wrote
// it. Throws what PrepareScene throws.
DetectionSequence WithRecordedClocks(const RunOptions& options,
                                     const RunRequest& request,
                                     const RefinementRecord& record,
                                     const DetectionSequence& detections);

// The effect of the cameras' recorded uncertainty on the joints of a run; null
// if the record has no covariance of any of the run's cameras.
std::unique_ptr<CameraUncertainty> UncertaintyOf(
    const RefinementRecord& record, const RunScene& scene,
    const Skeleton& detection_skeleton);

struct ReadyRecording {
  CameraRig cameras;  // of the request, after refinement and ground
  // The record of this refinement or, without one, of the calibration; its
  // covariance is rotated with the world by `ground`.
  std::optional<RefinementRecord> record;
  std::optional<Refinement> refinement;  // one change per used view
  // Change of the world by the refinement of cameras, before the transformation
  // to the floor; nullopt if no camera was changed or WorldMotionOf cannot
  // determine it.
  std::optional<WorldMotion> world_motion;
  std::optional<Ground> ground;
  bool misses_ground = false;  // requested, but GroundOf found none
  // The requested frames of all views with corrected clocks; nullopt:
  // unchanged.
  std::optional<DetectionSequence> detections;

  bool changes_cameras() const {
    return refinement.has_value() || ground.has_value();
  }
};

// Refines the parameters that the options request, from the matches of a
// tracking run and, if any were refined, again from those of a second run with
// the refined parameters. If clocks are requested, whole-frame lags are
// searched first, but ignored if people hardly move. Throws what PrepareScene
// throws.
ReadyRecording RefineRecording(const RunOptions& options,
                               const RunRequest& request,
                               const DetectionSequence& detections);

// `recorded`: the record of an earlier run in the request's calibration. `read`
// is called at most once, if the recording is needed. Throws what PrepareScene
// throws, and OptionError if `recorded` has clocks and the options request
// refinement, of clocks or cameras.
ReadyRecording MakeRecordingReady(
    const RunOptions& options, const RunRequest& request,
    const std::optional<RefinementRecord>& recorded,
    const std::function<DetectionSequence()>& read);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SESSION_READY_RECORDING_H_
