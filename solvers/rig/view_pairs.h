// How two views stand to each other, how far their clocks are apart and whose
// tracklet of one is whose in the other: all at once, from tracklets alone.
#ifndef KINEGRAPH_SOLVERS_RIG_VIEW_PAIRS_H_
#define KINEGRAPH_SOLVERS_RIG_VIEW_PAIRS_H_

#include <vector>

#include "solvers/rig/tracklets.h"
#include "solvers/rig/two_views.h"

namespace kinegraph {

// What the search knows beforehand.
struct PairSearchOptions {
  double frame_rate_hz = 25.0;
  double longest_lag_s = 10.0;
  // Standard deviation of the logarithm of the focal lengths; 0: known.
  double focal_sigma = 0.0;
  // Later attempts draw otherwise, and more.
  int attempt = 0;
};

struct TrackletMatch {
  int a = 0;  // indices among all tracklets
  int b = 0;
  double gain = 0.0;  // 0 .. 1: how near their joints are to epipolar lines
};

struct PairFit {
  int a = 0;
  int b = 0;
  int lag = 0;  // frame k of view a was taken with frame k + lag of view b
  RelativePose pose;
  std::vector<TrackletMatch> matches;
  // Seconds of people that fit, on joints and frames that the pose was not
  // fitted to, each less what anybody's joints would fit by chance.
  double evidence = 0.0;
  // The same of the best other explanation: a lag further than a quarter of a
  // second off, or a rotation more than 20 degrees off.
  double rival = 0.0;

  // What the pair is worth for joining views.
  double lead() const { return evidence - 0.5 * rival; }
  // Whether another lag or place explains nearly as much. Rivals of recorded
  // people have up to two thirds of the evidence (a fifth is usual), those of
  // people who walk rounds as regularly as clockwork 0.93 and more.
  bool is_undecided() const {
    constexpr double kNearly = 0.8;
    return rival >= kNearly * evidence;
  }
};

// Searches lag, pose and matches of views `a` and `b`. Without any evidence
// where nothing fits.
PairFit SearchViewPair(const std::vector<ViewTracklet>& tracklets,
                       const MotionSignals& signals, int a, int b,
                       const PairSearchOptions& options);

// Fits the pose anew to the points that the matches have in common, for the
// focal lengths of the tracklets' normalised coordinates.
void RefitPose(const std::vector<ViewTracklet>& tracklets, PairFit* pair);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_RIG_VIEW_PAIRS_H_
