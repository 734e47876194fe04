// Where the adjustment of a rig begins: the tree of the pairs of views that say
// most, one scale, and whose tracklets are one person's.
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
  // The joined views, ascending, and of each its camera, with lengths in
  // baselines of the first pair, and its lag: moment k of the recording is
  // frame k + lag of the view.
  std::vector<int> views;
  CameraRig cameras;
  std::vector<int> lag_frames;
  // By what they were joined.
  std::vector<ViewTracklet> tracklets;
  std::vector<PairFit> pairs;
};

struct RigSearch {
  double focal_sigma = 0.0;     // of RigInput
  double longest_lag_s = 10.0;  // 0: the views are in step
  int attempt = 0;              // PairSearchOptions
  std::function<void(int done, int total)> progress;  // may be empty
};

// `recording` has every frame from the first to the last, at its time.
// `intrinsics` as in RigInput: focal lengths that are not known are tried.
// Without views where no two see the same people move; tracklets and pairs are
// there all the same.
RigStart FindRigStart(const DetectionSequence& recording,
                      const CameraRig& intrinsics, const RigSearch& search);

// The people of the joined views, from the matches of the pairs, the surest
// first. Views are counted among the joined ones, and frames are those of
// `recording` realigned by the lags.
FrozenMatches PeopleOf(const DetectionSequence& recording,
                       const RigStart& start);

// Some of the views.
DetectionSequence OfViews(const DetectionSequence& detections,
                          const std::vector<int>& views);

// How well each view agrees with the others, 0 .. 1 (PairAgreement::score).
std::vector<double> AgreementsOfViews(const CameraRig& cameras,
                                      const DetectionSequence& aligned);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_RIG_RIG_START_H_
