#include "solvers/session/ready_recording.h"

#include <utility>

#include "core/base/error.h"
#include "solvers/session/refine_recording.h"

namespace kinegraph {
namespace {

void Refine(const RunOptions& options, const RunRequest& request,
            const DetectionSequence& recording, ReadyRecording* ready) {
  RefinedRecording refined = RefineRecording(options, request, recording);
  ready->cameras = std::move(refined.cameras);
  ready->record = std::move(refined.record);
  ready->refinement = std::move(refined.refinement);
  ready->detections = std::move(refined.detections);
}

// The floor, from one more run over the recording with the cameras as they are
// now.
void StandOnGround(const RunOptions& options, const RunRequest& request,
                   const DetectionSequence& recording, ReadyRecording* ready) {
  RunRequest refined = request;
  refined.cameras = ready->cameras;
  ready->ground = FindGround(options, refined, recording);
  ready->misses_ground = !ready->ground.has_value();
  if (ready->misses_ground) return;
  ready->cameras = OnGround(ready->cameras, *ready->ground);
  if (ready->record.has_value()) TurnRecord(*ready->ground, &*ready->record);
}

}  // namespace

bool ChangesCameras(const RunOptions& options) {
  return options.refine.any() || options.refine.ground != GroundKind::kOff;
}

ReadyRecording MakeRecordingReady(
    const RunOptions& options, const RunRequest& request,
    const std::optional<RefinementRecord>& recorded,
    const std::function<DetectionSequence()>& read) {
  ReadyRecording ready;
  ready.cameras = request.cameras;
  ready.record = recorded;
  const bool has_clocks = recorded.has_value() && recorded->has_clocks();
  if (has_clocks && options.refine.any()) {
    throw OptionError(
        options.refine.refine_clock ? "cameras.refine_clock" : "cameras.refine",
        "the clocks of this calibration are refined already: start from the "
        "calibration as it was before, or leave out cameras.refine and "
        "cameras.refine_clock");
  }
  if (has_clocks) {
    ready.detections = WithRecordedClocks(options, request, *recorded, read());
  }
  const bool needs_ground = options.refine.ground == GroundKind::kFeet;
  if (!options.refine.any() && !needs_ground) return ready;
  DetectionSequence own;
  if (!ready.detections.has_value()) own = read();
  if (options.refine.any()) Refine(options, request, own, &ready);
  if (needs_ground) {
    StandOnGround(options, request,
                  ready.detections.has_value() ? *ready.detections : own,
                  &ready);
  }
  return ready;
}

}  // namespace kinegraph
