// The protocol held_out_camera: each camera in turn is left out entirely, and
// its detections are compared with the tracks made from the other cameras.
#ifndef KINEGRAPH_APPS_COMMON_HELD_OUT_CAMERAS_H_
#define KINEGRAPH_APPS_COMMON_HELD_OUT_CAMERAS_H_

#include <string>
#include <vector>

#include "apps/common/evaluation_output.h"
#include "core/base/frame_range.h"
#include "core/data/held_out.h"
#include "core/geometry/camera.h"
#include "solvers/session/scene.h"

namespace kinegraph {

// The values of evaluate's flags of the same names. Error messages refer to
// them as --name.
struct HeldOutRequest {
  std::string cameras;
  std::string detections;
  std::string config;
  std::string set;
  std::string mode;
  std::string held_out_set;
  std::string reference;
  std::vector<std::string> runs;   // one per view; empty: tracked here
  std::vector<FrameRange> frames;  // empty: all
  std::vector<FrameRange> folds;   // two, or none
};

EvaluationOutput ScoreHeldOutCameras(const HeldOutRequest& request);

// Reads detections. If the file `cameras` records clocks (RefinementRecord),
// they are applied to the times.
DetectionSequence ReadClockedDetections(const std::string& detections,
                                        const std::string& cameras,
                                        const RunOptions& options,
                                        const RunRequest& request);

// The detections in `frames`; all of them if `frames` is empty.
HeldOutSet PartIn(const std::vector<FrameRange>& frames, HeldOutSet set);

// Throws InputError, naming the fold, if one of `folds` has no detection of the
// set, because what is chosen on one fold is scored on the other.
void RequireDetections(const std::vector<FrameRange>& folds,
                       const HeldOutSet& set);

// The default limit of an error: a tenth of the camera's image width. Throws
// InputError, naming `file`, if the width is unknown.
double HeldOutCapPx(const Camera& camera, const std::string& file);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_HELD_OUT_CAMERAS_H_
