// Searches simultaneously for the relative pose of two views, the lag between
// their clocks and the matches of their tracklets.
#ifndef KINEGRAPH_SOLVERS_RIG_VIEW_PAIRS_H_
#define KINEGRAPH_SOLVERS_RIG_VIEW_PAIRS_H_

#include <vector>

#include "solvers/rig/tracklets.h"
#include "solvers/rig/two_views.h"

namespace kinegraph {

// What is known before the search.
struct PairSearchOptions {
  double frame_rate_hz = 25.0;
  double longest_lag_s = 10.0;
  // Standard deviation of the logarithm of the focal lengths; 0: exact.
  double focal_sigma = 0.0;
  // Later attempts use other random draws, and more draws and lags.
  int attempt = 0;
};

struct TrackletMatch {
  int a = 0;  // indices into all tracklets
  int b = 0;
  double gain = 0.0;  // 0 .. 1, higher for joints closer to epipolar lines
};

struct PairFit {
  int a = 0;
  int b = 0;
  int lag = 0;  // frame k of view a is simultaneous with k + lag of view b
  RelativePose pose;
  std::vector<TrackletMatch> matches;
  // Sum over the matches of duration [s] times (gain - chance): the gain on
  // joints and frames that were held out of the fit, minus the gain that
  // unrelated joints have by chance.
  double evidence = 0.0;
  // The evidence of the best different explanation, i.e. with a lag that
  // differs by more than 0.25 s or a rotation that differs by more than 20
  // degrees.
  double rival = 0.0;
  // The evidence of the best explanation with this lag, another pose and other
  // matches.
  double rival_pose = 0.0;

  // Score [s] by which pairs are ranked when views are joined, the greatest
  // first.
  double lead() const { return evidence - 0.5 * rival; }
  // Whether another lag or pose explains nearly as much. For recorded people
  // the rival has up to two thirds of the evidence (typically a fifth), for
  // simulated people who walk in circles at a constant speed at least 0.93.
  bool is_undecided() const { return rival >= 0.8 * evidence; }
  // Whether another pose at this lag, with people exchanged, explains nearly as
  // much. In simulated rooms that pose typically has a tenth of the evidence
  // and at most 0.6 to 0.7 of it; with two people who make the same movements
  // face to face it has 0.7 or more.
  bool is_pose_undecided() const { return rival_pose >= 0.67 * evidence; }
};

// Searches lag, pose and matches of views `a` and `b`. The evidence is 0 if
// nothing fits.
PairFit SearchViewPair(const std::vector<ViewTracklet>& tracklets,
                       const MotionSignals& signals, int a, int b,
                       const PairSearchOptions& options);

// Refits the pose to the common points of the matches, at the focal lengths of
// the tracklets' normalised coordinates, i.e. with a magnification of 1. With
// fewer than 16 points only the magnification is set.
void RefitPose(const std::vector<ViewTracklet>& tracklets, PairFit* pair);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_RIG_VIEW_PAIRS_H_
