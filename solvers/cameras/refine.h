// Refines the cameras and clocks of a recording from its own people, and
// decides on held-out halves of the recording and of its joints, and for
// cameras also on views excluded from the fit, whether to keep the result.
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

// ---- Views that are out of sync, according to a fit of the clocks ----

// Median of a clock parameter over all views. The first view's clock is the
// reference of a fit but may itself be wrong, so deviations of clocks are
// measured from the median.
double UsualClock(const std::vector<CameraChange>& changes, int place);

// Whether the view's offset or drift (`place`; drift times `span_s`) deviates
// from the median, in either direction, by more than four standard deviations
// and more than 0.15 frames, but by less than motion segments can determine
// (kFarthestClockS). False if `fit` did not estimate this parameter.
bool IsLate(const BundleResult& fit, size_t view, int place, double frame_s,
            double span_s);

// Whether IsLate holds for the offset or drift of any view.
bool AnyIsLate(const BundleResult& fit, double frame_s, double span_s);

// One step of the refinement: the clocks, or the cameras.
struct RefineStep {
  std::string what;  // "clock", "shift", ...
  bool taken = false;
  std::string reason;  // why it was rejected; empty if taken
  FitGain gain;        // on the held-out halves of the recording
  // Gain in cameras excluded from the fit, if this was tested and there are
  // enough cameras.
  std::optional<FitGain> left_out = std::nullopt;
};

struct Refinement {
  std::vector<CameraChange> changes;  // of the steps taken; one per view
  // Standard deviations of the changes; zero for parameters not estimated.
  std::vector<CameraChange> sigmas;
  // Parameters of the steps taken and the covariance matrix of all of them,
  // view by view; empty if none was taken.
  std::vector<std::vector<int>> places;  // one list per view
  Eigen::MatrixXd covariance;
  std::vector<RefineStep> steps;
  double largest_correlation = 0.0;  // between a clock and a camera parameter
  int64_t segments = 0;              // number of motion segments used
  // Frame numbers by which each view was shifted before RefineScene. Set by its
  // caller, which also includes these lags in the offsets of `changes`.
  std::vector<int64_t> lag_numbers;
  bool hardly_moves = false;  // too little motion to determine clocks

  bool any_taken() const;
};

// Refines clocks first, then cameras, because a clock error looks like a shift
// in the direction of walking, which a change of the camera would absorb. If a
// clock is estimated farther from the median than motion segments can
// determine, the clocks are rejected and the cameras refined without them.
Refinement RefineScene(const CameraRig& cameras,
                       const DetectionSequence& detections,
                       const FrozenMatches& matches,
                       const RefineOptions& options,
                       const BundleOptions& bundle = {});

// Sets samples_at_once for persistent detector errors: the observations of a
// joint in one view within a second count as one independent sample.
BundleOptions WithLastingErrors(BundleOptions options,
                                const SceneSegments& segments);

// The second round: with cameras and clocks nearly right, the tracker matches
// more detections and only the detector's noise remains. Jointly re-estimates
// all parameters that `refinement` has changed, from their current values.
// `detections`: those of the first round after WithClocks. `matches`: the
// matches obtained from these with the refined cameras. Decisions are not
// revised.
void RefineAgain(const CameraRig& cameras, const DetectionSequence& detections,
                 const FrozenMatches& matches, const BundleOptions& bundle,
                 Refinement* refinement);

// The detections with each view's capture times corrected by its clock's offset
// and drift, in the frames nearest to the corrected times. Detections more than
// one frame interval from any frame are dropped; if several captures of a view
// are nearest to one frame, only the nearest of them is kept.
DetectionSequence WithClocks(const DetectionSequence& detections,
                             const std::vector<CameraChange>& changes);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_CAMERAS_REFINE_H_
