// How well cameras explain a recording, and whether others do it better.
#ifndef KINEGRAPH_SOLVERS_SCENE_FIT_ERROR_H_
#define KINEGRAPH_SOLVERS_SCENE_FIT_ERROR_H_

#include <vector>

#include "core/geometry/camera.h"
#include "solvers/scene/camera_change.h"
#include "solvers/scene/segments.h"

namespace kinegraph {

// How well given cameras explain the recording: each stretch's state is
// estimated for them, and its residuals summed by short bins of time.
struct FitError {
  // Sums of min(|residual|, cap) [px] and counts.
  std::vector<std::vector<double>> sum_px;  // [view][bin]
  std::vector<std::vector<double>> count;   // [view][bin]
  // What lasts over a stretch: the length of its mean residual at its depth,
  // summed by view, and the number of stretches.
  std::vector<double> lasting_m;
  std::vector<double> segments;
  double LastingM(size_t view) const;
  double MeanPx() const;  // over everything
  double MeanPx(int view) const;
  // Takes the bins of `other` behind its own.
  void Append(const FitError& other);
};

FitError MeasureFit(const CameraRig& cameras, const SceneSegments& segments,
                    const std::vector<CameraChange>& changes,
                    const SegmentOptions& options, double cap_px = 30.0);

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
  // The rule for whatever is fitted to matches: the gain is certain and no
  // trifle.
  static constexpr double kLeastShare = 0.05;
  bool is_enough() const {
    return certain() && before_px - after_px >= kLeastShare * before_px;
  }
};
FitGain CompareFits(const FitError& before, const FitError& after,
                    int view = -1);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SCENE_FIT_ERROR_H_
