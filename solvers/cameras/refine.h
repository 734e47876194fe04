// Refines the cameras and clocks of a recording from its own people, and
// decides from the other half of the recording whether it was worth it.
#ifndef KINEGRAPH_SOLVERS_CAMERAS_REFINE_H_
#define KINEGRAPH_SOLVERS_CAMERAS_REFINE_H_

#include <optional>
#include <string>
#include <vector>

#include "core/data/detection.h"
#include "core/geometry/camera.h"
#include "core/tracking/replay.h"
#include "solvers/cameras/bundle.h"
#include "solvers/cameras/fit_error.h"
#include "solvers/cameras/refine_options.h"

namespace kinegraph {

FreeParameters CameraParametersOf(RefineKind kind);

// ---- Which views a fit of the clocks finds to be out of time ----

// The first view's clock is the reference of a fit, which does not make it
// right: views are late against the median of all.
double UsualClock(const std::vector<CameraChange>& changes, int place);

// Whether the view's offset or drift (`place`) is off by more than four of its
// standard deviations and more than 0.15 frames, over a recording of `span_s`
// for the drift, and less than stretches tell (kFarthestClockS). `fit` has the
// clocks free and no camera.
bool IsLate(const BundleResult& fit, size_t view, int place, double frame_s,
            double span_s);

// Whether any view's offset or drift is.
bool AnyIsLate(const BundleResult& fit, double frame_s, double span_s);

// One step of the refinement: the clocks, or the cameras.
struct RefineStep {
  std::string what;  // "clock", "shift", ...
  bool taken = false;
  std::string reason;  // why not, in words; empty when taken
  FitGain gain;        // on the other half of the recording
  // In cameras that took no part, where that was asked and there are enough.
  std::optional<FitGain> left_out = std::nullopt;
};

struct Refinement {
  std::vector<CameraChange> changes;  // of the steps taken; one a view
  // Standard deviations of the changes, zero where nothing was estimated.
  std::vector<CameraChange> sigmas;
  // Of the steps taken: their parameters, and the covariance of all of them,
  // view after view; empty when none was taken.
  std::vector<std::vector<int>> places;  // one list a view
  Eigen::MatrixXd covariance;
  std::vector<RefineStep> steps;
  double largest_correlation = 0.0;  // of a clock with a camera
  int64_t segments = 0;              // that were used
  // Whole frames that each view was moved by beforehand; part of `changes`.
  std::vector<int> lag_frames;
  bool hardly_moves = false;  // nobody, so that no clock is told

  bool any_taken() const;
};

// Clocks come first, then cameras: a clock that is late looks like a shift that
// follows the walking, and a camera that is moved would take it over.
Refinement RefineScene(const CameraRig& cameras,
                       const DetectionSequence& detections,
                       const FrozenMatches& matches,
                       const RefineOptions& options,
                       const BundleOptions& bundle = {});

// Errors of a detector last: what a view observes of a joint within a second is
// one independent sample, however many frames and segments it has.
BundleOptions WithLastingErrors(BundleOptions options,
                                const SceneSegments& segments);

// The second round: with cameras and clocks nearly right, the tracker matches
// more and the noise is the detector's alone. Estimates what `refinement` has
// taken once more, all of it together, from where it is. `detections` are those
// of the first round with the clocks set right (WithClocks), `matches` theirs
// with the refined cameras. Decisions stay.
void RefineAgain(const CameraRig& cameras, const DetectionSequence& detections,
                 const FrozenMatches& matches, const BundleOptions& bundle,
                 Refinement* refinement);

// The detections with each view's capture times moved by its clock's offset
// and drift. Measurements that are off by more than half a frame join the
// frame that is nearest to their own time.
DetectionSequence WithClocks(const DetectionSequence& detections,
                             const std::vector<CameraChange>& changes);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_CAMERAS_REFINE_H_
