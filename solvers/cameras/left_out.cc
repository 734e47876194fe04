#include "solvers/cameras/left_out.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <utility>

namespace kinegraph {
namespace {

constexpr double kCapPx = 30.0;

// Residual of a measurement, capped; equal to the cap if the point has no
// image.
double CappedPx(const CameraRig& cameras,
                const std::vector<CameraChange>& changes,
                const MotionSegment& segment, const SegmentState& state,
                const SegmentMeasurement& one) {
  const auto v = static_cast<size_t>(one.view_idx);
  const auto r =
      SegmentResidual(cameras[v], changes[v], segment, state, one, 1.0);
  return r.has_value() ? std::min(kCapPx, r->norm() * one.sigma_px) : kCapPx;
}

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
    int first_view = -1;
    bool by_two = false;
    for (const SegmentMeasurement& measurement : segment.measurements) {
      if (measurement.view_idx == view) {
        one.left_out.push_back(measurement);
        continue;
      }
      by_two |= first_view >= 0 && first_view != measurement.view_idx;
      first_view = measurement.view_idx;
      others.push_back(measurement);
    }
    if (by_two) split.push_back(std::move(one));
  }
  return split;
}

// Adds the errors in the held-out view, at the states estimated from the
// others.
void AddLeftOut(const CameraRig& cameras,
                const std::vector<SplitSegment>& split,
                const std::vector<CameraChange>& changes, double noise_scale,
                const SegmentOptions& options, double bin_s,
                const std::map<double, Eigen::Index>& bins, FitError* error) {
  for (const SplitSegment& one : split) {
    if (one.left_out.empty()) continue;
    SegmentState state = one.others.state;
    const bool solved = SolveSegment(cameras, changes, one.others, noise_scale,
                                     options, &state);
    const Eigen::Index bin = bins.at(std::floor(one.others.middle_s / bin_s));
    for (const SegmentMeasurement& measurement : one.left_out) {
      error->sum_px(measurement.view_idx, bin) +=
          solved ? CappedPx(cameras, changes, one.others, state, measurement)
                 : kCapPx;
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
  const std::map<double, Eigen::Index> bins = FilledBins(segments);
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
      AddLeftOut(cameras, split, changes, segments.noise_scale,
                 options.segments, BinLength(segments), bins, error);
    };
    add(start, &before);
    add(fit.usable ? fit.changes : start, &after);
  }
  return CompareFits(before, after);
}

}  // namespace kinegraph
