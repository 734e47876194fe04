// Initial estimate of a rig: a spanning tree of the best pairs of views, a
// common scale, and the tracklets of each person.
#ifndef KINEGRAPH_SOLVERS_RIG_RIG_START_H_
#define KINEGRAPH_SOLVERS_RIG_RIG_START_H_

#include <functional>
#include <vector>

#include "core/data/detection.h"
#include "core/geometry/camera.h"
#include "core/tracking/replay.h"
#include "solvers/rig/tracklets.h"
#include "solvers/rig/view_pairs.h"

namespace kinegraph {

struct RigStart {
  // The joined views, ascending, with the camera of each (unit of length: the
  // baseline of the first pair) and its lag: the instant of frame k of the
  // recording is that of frame k + lag of the view.
  std::vector<int> views;
  CameraRig cameras;
  std::vector<int> lag_frames;
  // The tracklets and pairs from which the views were joined.
  std::vector<ViewTracklet> tracklets;
  std::vector<PairFit> pairs;
};

struct RigSearch {
  double focal_sigma = 0.0;  // as in RigInput
  // Lags up to this are searched, but at most two fifths of the recording. 0:
  // the views are synchronised.
  double longest_lag_s = 10.0;
  int attempt = 0;                                    // as in PairSearchOptions
  std::function<void(int done, int total)> progress;  // may be empty
};

// `recording` must contain every frame from the first to the last, at its
// nominal time. `intrinsics`: as in RigInput; unknown focal lengths are
// searched. If no two views share moving people, the result has no views, but
// still the tracklets and pairs.
RigStart FindRigStart(const DetectionSequence& recording,
                      const CameraRig& intrinsics, const RigSearch& search);

// The people seen by at least two joined views: tracklets merged by the matches
// of the pairs, matches of the largest gain times duration first. View indices
// are positions among the joined views; frames refer to `recording` realigned
// by the lags.
FrozenMatches PeopleOf(const DetectionSequence& recording,
                       const RigStart& start);

// The detections of the given views only.
DetectionSequence OfViews(const DetectionSequence& detections,
                          const std::vector<int>& views);

// Agreement of each view with the others, 0 .. 1 (PairAgreement::score).
// `aligned`: one view per camera, realigned by the lags.
std::vector<double> AgreementsOfViews(const CameraRig& cameras,
                                      const DetectionSequence& aligned);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_RIG_RIG_START_H_
