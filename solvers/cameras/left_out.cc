#include "solvers/cameras/left_out.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>

namespace kinegraph {
namespace {

// A segment with the measurements of the other views, and those of the held-out
// view.
struct SplitSegment {
  MotionSegment others;
  std::vector<SegmentMeasurement> left_out;
};

// The segments that at least two views other than `view` see.
std::vector<SplitSegment> SplitBy(const SceneSegments& segments, int view) {
  std::vector<SplitSegment> split;
  for (const MotionSegment& segment : segments.segments) {
    SplitSegment one;
    one.others = segment;
    std::vector<SegmentMeasurement>& others = one.others.measurements;
    others.clear();
    int previous_view = -1;
    bool by_two = false;
    for (const SegmentMeasurement& measurement : segment.measurements) {
      if (measurement.view_idx == view) {
        one.left_out.push_back(measurement);
        continue;
      }
      by_two |= previous_view >= 0 && previous_view != measurement.view_idx;
      previous_view = measurement.view_idx;
      others.push_back(measurement);
    }
    if (by_two) split.push_back(std::move(one));
  }
  return split;
}

// Adds the errors in the held-out view, at the states estimated from the
// others.
void AddLeftOut(const CameraRig& cameras, const SceneSegments& segments,
                const std::vector<SplitSegment>& split,
                const std::vector<CameraChange>& changes,
                const SegmentOptions& options,
                const std::map<int64_t, Eigen::Index>& bins, FitError* error) {
  for (const SplitSegment& one : split) {
    if (one.left_out.empty()) continue;
    SegmentState state = one.others.state;
    const bool solved = SolveSegment(cameras, changes, one.others,
                                     segments.noise_scale, options, &state);
    const Eigen::Index bin = bins.at(BinOf(segments, one.others));
    for (const SegmentMeasurement& measurement : one.left_out) {
      const auto v = static_cast<size_t>(measurement.view_idx);
      const auto r = solved
                         ? SegmentResidual(cameras[v], changes[v], one.others,
                                           state, measurement, 1.0)
                         : std::nullopt;
      error->sum_px(measurement.view_idx, bin) +=
          r.has_value()
              ? std::min(FitError::kMostPx, r->norm() * measurement.sigma_px)
              : FitError::kMostPx;
      error->count(measurement.view_idx, bin) += 1.0;
    }
  }
}

}  // namespace

std::optional<FitGain> LeftOutGain(const CameraRig& cameras,
                                   const SceneSegments& segments,
                                   const FreeParameters& free,
                                   const std::vector<CameraChange>& start,
                                   const BundleOptions& options) {
  constexpr size_t kFewestViews = 4;
  if (cameras.size() < kFewestViews) return std::nullopt;
  BundleOptions changes_alone = options;
  changes_alone.wants_covariance = false;
  const std::map<int64_t, Eigen::Index> bins = FilledBins(segments);
  FitError before;
  before.sum_px.setZero(static_cast<Eigen::Index>(cameras.size()),
                        static_cast<Eigen::Index>(bins.size()));
  before.count = before.sum_px;
  FitError after = before;
  for (size_t v = 0; v < cameras.size(); ++v) {
    const std::vector<SplitSegment> split =
        SplitBy(segments, static_cast<int>(v));
    SceneSegments others = segments;
    others.segments.clear();
    for (const SplitSegment& one : split) others.segments.push_back(one.others);
    std::vector<char> moves(cameras.size(), 1);
    moves[v] = 0;
    const BundleResult fit =
        AdjustBundle(cameras, others, free, start, changes_alone, moves);
    const auto add = [&](const std::vector<CameraChange>& changes,
                         FitError* error) {
      AddLeftOut(cameras, segments, split, changes, options.segments, bins,
                 error);
    };
    add(start, &before);
    add(fit.usable ? fit.changes : start, &after);
  }
  return CompareFits(before, after);
}

}  // namespace kinegraph
