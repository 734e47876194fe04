// How well cameras explain a recording, and whether others do it better.
#ifndef KINEGRAPH_SOLVERS_CAMERAS_FIT_ERROR_H_
#define KINEGRAPH_SOLVERS_CAMERAS_FIT_ERROR_H_

#include <Eigen/Core>
#include <map>
#include <vector>

#include "core/geometry/camera.h"
#include "solvers/cameras/bundle.h"
#include "solvers/cameras/camera_change.h"
#include "solvers/cameras/segments.h"

namespace kinegraph {

// How well given cameras explain the recording: each stretch's state is
// estimated for them, and its residuals summed by short bins of time.
struct FitError {
  // Sums of min(|residual|, 30 px) and counts, [view, bin].
  Eigen::ArrayXXd sum_px;
  Eigen::ArrayXXd count;
  // What lasts over a stretch: the length of its mean residual at its depth,
  // summed by view, and the number of stretches.
  Eigen::ArrayXd lasting_m;
  Eigen::ArrayXd segments;
  double LastingM(size_t view) const;
  double MeanPx(int view = -1) const;  // of all views: -1
};

// Bins of time that hold any stretch, however long the clock stands still in
// between, by floor(middle_s / BinLength), each with its column.
std::map<double, Eigen::Index> FilledBins(const SceneSegments& segments);

FitError MeasureFit(const CameraRig& cameras, const SceneSegments& segments,
                    const std::vector<CameraChange>& changes,
                    const SegmentOptions& options);

// The paired 95 % interval of MeanPx of `before` less that of `after`
// (moving blocks of two bins), over one view or all (-1).
struct FitGain {
  double before_px = 0.0;
  double after_px = 0.0;
  double low_px = 0.0;  // of the gain
  double high_px = 0.0;
  // Of one view: what lasts over stretches, at people's depth.
  double lasting_before_m = 0.0;
  double lasting_after_m = 0.0;
  // Share of it that is gone.
  double explained() const {
    return lasting_before_m > 0.0 ? 1.0 - lasting_after_m / lasting_before_m
                                  : 0.0;
  }
  // The interval excludes zero: the cameras after explain the recording better.
  bool certain() const { return low_px > 0.0; }
  double share() const {
    return before_px > 0.0 ? 1.0 - after_px / before_px : 0.0;
  }
  // The rule for whatever is fitted to matches: the gain is certain and no
  // trifle.
  static constexpr double kLeastShare = 0.05;
  bool is_enough() const { return certain() && share() >= kLeastShare; }
};
FitGain CompareFits(const FitError& before, const FitError& after,
                    int view = -1);

// What a fit of some parameters (AdjustBundle) gives on the half of the
// recording that it has not seen, both ways round.
struct CrossedGain {
  FitGain all;
  std::vector<FitGain> views;
};
CrossedGain CrossFit(const CameraRig& cameras, const SceneSegments& segments,
                     Halving halving, const FreeParameters& free,
                     const std::vector<CameraChange>& start,
                     const BundleOptions& options,
                     const std::vector<char>& moves = {});

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_CAMERAS_FIT_ERROR_H_
