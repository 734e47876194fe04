#ifndef KINEGRAPH_SOLVERS_CAMERAS_FIT_ERROR_H_
#define KINEGRAPH_SOLVERS_CAMERAS_FIT_ERROR_H_

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <vector>

#include "core/geometry/camera.h"
#include "solvers/cameras/bundle.h"
#include "solvers/cameras/camera_change.h"
#include "solvers/cameras/segments.h"

namespace kinegraph {

// How well given cameras explain a recording: each segment's state is estimated
// with them, and its residuals are summed in short time bins.
struct FitError {
  // Upper bound of the error of a measurement [px], and the error where the
  // joint has no image or the segment's state cannot be found.
  static constexpr double kMostPx = 30.0;
  // Sums of min(|residual|, kMostPx) and counts, [view, bin].
  Eigen::ArrayXXd sum_px;
  Eigen::ArrayXXd count;
  // Errors that persist over a segment [m]: the length of its mean residual at
  // its depth, summed by view; and the number of segments by view.
  Eigen::ArrayXd lasting_m;
  Eigen::ArrayXd segments;
  // Means over segments and over measurements; 0 without any.
  double LastingM(size_t view) const;
  double MeanPx(int view = -1) const;  // -1: all views
};

// Column of each time bin with at least one segment, keyed by the bin's index
// (BinOf); empty bins have no column.
std::map<int64_t, Eigen::Index> FilledBins(const SceneSegments& segments);

// The errors of the cameras after `changes`; each segment is solved with these.
FitError MeasureFit(const CameraRig& cameras, const SceneSegments& segments,
                    const std::vector<CameraChange>& changes,
                    const SegmentOptions& options);

// The decrease of MeanPx from `before` to `after` in one view or in all (-1),
// with its paired 95 % interval (moving-block bootstrap with blocks of two
// bins); both ends are 0 if fewer than two bins have measurements.
struct FitGain {
  double before_px = 0.0;
  double after_px = 0.0;
  double low_px = 0.0;  // of the gain
  double high_px = 0.0;
  // FitError::LastingM of the view; 0 for all views.
  double lasting_before_m = 0.0;
  double lasting_after_m = 0.0;
  // The fraction of the persistent error that is removed.
  double explained() const {
    return lasting_before_m > 0.0 ? 1.0 - lasting_after_m / lasting_before_m
                                  : 0.0;
  }
  // Whether the interval lies above zero, i.e. the cameras after the change
  // explain the recording better.
  bool certain() const { return low_px > 0.0; }
  // The fraction of the mean error that is removed.
  double share() const {
    return before_px > 0.0 ? 1.0 - after_px / before_px : 0.0;
  }
  // Criterion for anything fitted to matches: a gain that is certain and not
  // negligible.
  static constexpr double kLeastShare = 0.05;
  bool is_enough() const { return certain() && share() >= kLeastShare; }
};
FitGain CompareFits(const FitError& before, const FitError& after,
                    int view = -1);

// Cross-validated gain of a fit of some parameters (AdjustBundle): cameras are
// fitted to each half of the segments and measured on the other half, and the
// errors of both halves are pooled.
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
