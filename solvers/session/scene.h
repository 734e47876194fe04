// Set-up of a run before its first frame: cameras paired with views, skeleton
// and rate of the tracks.
#ifndef KINEGRAPH_SOLVERS_SESSION_SCENE_H_
#define KINEGRAPH_SOLVERS_SESSION_SCENE_H_

#include <string>
#include <vector>

#include "core/base/frame_range.h"
#include "core/data/detection.h"
#include "core/data/identity_edit.h"
#include "core/data/pose.h"
#include "core/geometry/camera.h"
#include "core/tracking/estimator.h"
#include "solvers/session/options.h"

namespace kinegraph {

enum class PairedBy;  // core/io/detections/view_pairing.h

// Input of a run besides its options.
struct RunRequest {
  CameraRig cameras;                         // as in the calibration file
  std::vector<std::string> without_cameras;  // names of views or cameras
  std::vector<FrameRange> frames;            // ascending; empty: all
  int threads = 1;                           // does not affect the result
  // Applied in order after automatic linking (core/identity/edits.h).
  std::vector<IdentityEdit> corrections;
  // Lower bound on the matches stored with each pose; output.observations
  // raises it to kWeights.
  KeptMatches kept_matches = KeptMatches::kNone;
};

// Everything about a run except its frames.
struct RunScene {
  SceneModel model;                     // cameras in the order of used views
  std::vector<int> used_views;          // indices into the source's views
  std::vector<std::string> view_names;  // of the used views
  TrackHeader header;                   // of the run's tracks
  PairedBy paired_by = {};              // how views were paired with cameras
  // Joints with a lower confidence are absent (presence.h); 0: none are.
  double least_confidence = 0.0;
};

// Pairs views with cameras, excludes unwanted views, determines skeleton and
// frame rate. Throws InputError or OptionError for inconsistent input.
RunScene PrepareScene(const RunOptions& options, const RunRequest& request,
                      const DetectionHeader& detections);

// Writes the used views of `frame`, without absent joints, to `kept`; `frame`
// receives the earlier views of `kept` instead.
void KeepUsedViews(const RunScene& scene, DetectionFrame* frame,
                   DetectionFrame* kept);
// The used views of all frames, without absent joints.
DetectionSequence UsedViewsOf(const RunScene& scene,
                              DetectionSequence detections);

// The frames that the request selects.
DetectionSequence AskedFrames(const RunRequest& request,
                              const DetectionSequence& detections);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SESSION_SCENE_H_
