#include "solvers/cameras/fit_error.h"

#include <algorithm>
#include <cstddef>
#include <map>

#include "core/evaluation/statistics.h"

namespace kinegraph {
namespace {

// Adds the errors of one segment, at its best state given the changes.
void AddSegment(const CameraRig& cameras, const MotionSegment& segment,
                const std::vector<CameraChange>& changes, double noise_scale,
                const SegmentOptions& options, Eigen::Index bin,
                FitError* error) {
  SegmentState state = segment.state;
  const bool solved =
      SolveSegment(cameras, changes, segment, noise_scale, options, &state);
  // Sum of x and y, and number of residuals.
  std::vector<Eigen::Vector3d> sums(cameras.size(), Eigen::Vector3d::Zero());
  for (const SegmentMeasurement& one : segment.measurements) {
    const auto v = static_cast<size_t>(one.view_idx);
    double distance_px = FitError::kMostPx;
    const auto r = solved ? SegmentResidual(cameras[v], changes[v], segment,
                                            state, one, 1.0)
                          : std::nullopt;
    if (r.has_value()) {
      const Eigen::Vector2d residual_px = *r * one.sigma_px;
      distance_px = std::min(FitError::kMostPx, residual_px.norm());
      sums[v].head<2>() +=
          distance_px / std::max(1e-9, residual_px.norm()) * residual_px;
      sums[v].z() += 1.0;
    }
    error->sum_px(one.view_idx, bin) += distance_px;
    error->count(one.view_idx, bin) += 1.0;
  }
  for (size_t v = 0; v < cameras.size(); ++v) {
    if (sums[v].z() == 0.0) continue;
    const auto i = static_cast<Eigen::Index>(v);
    error->lasting_m[i] += sums[v].head<2>().norm() / sums[v].z() *
                           cameras[v].Depth(PositionOf(segment)) /
                           cameras[v].focal_px();
    error->segments[i] += 1.0;
  }
}

// Concatenates the bins.
FitError Joined(const FitError& a, const FitError& b) {
  FitError all;
  all.sum_px.resize(a.sum_px.rows(), a.sum_px.cols() + b.sum_px.cols());
  all.sum_px << a.sum_px, b.sum_px;
  all.count.resize(a.sum_px.rows(), all.sum_px.cols());
  all.count << a.count, b.count;
  all.lasting_m = a.lasting_m + b.lasting_m;
  all.segments = a.segments + b.segments;
  return all;
}

// The errors of one view, or of all (-1), by bin.
RatioSeries SeriesOf(const FitError& error, int view) {
  RatioSeries series;
  for (Eigen::Index bin = 0; bin < error.sum_px.cols(); ++bin) {
    RatioUnit unit;
    unit.sum = view < 0 ? error.sum_px.col(bin).sum() : error.sum_px(view, bin);
    unit.weight =
        view < 0 ? error.count.col(bin).sum() : error.count(view, bin);
    if (unit.weight > 0.0) series.push_back(unit);
  }
  return series;
}

}  // namespace

std::map<int64_t, Eigen::Index> FilledBins(const SceneSegments& segments) {
  std::map<int64_t, Eigen::Index> bins;
  for (const MotionSegment& segment : segments.segments) {
    bins[BinOf(segments, segment)] = 0;
  }
  Eigen::Index place = 0;
  for (auto& bin : bins) bin.second = place++;
  return bins;
}

FitError MeasureFit(const CameraRig& cameras, const SceneSegments& segments,
                    const std::vector<CameraChange>& changes,
                    const SegmentOptions& options) {
  const std::map<int64_t, Eigen::Index> bins = FilledBins(segments);
  const auto views = static_cast<Eigen::Index>(cameras.size());
  FitError error;
  error.sum_px.setZero(views, static_cast<Eigen::Index>(bins.size()));
  error.count = error.sum_px;
  error.lasting_m.setZero(views);
  error.segments = error.lasting_m;
  for (const MotionSegment& segment : segments.segments) {
    AddSegment(cameras, segment, changes, segments.noise_scale, options,
               bins.at(BinOf(segments, segment)), &error);
  }
  return error;
}

double FitError::LastingM(size_t view) const {
  const auto v = static_cast<Eigen::Index>(view);
  return segments[v] > 0.0 ? lasting_m[v] / segments[v] : 0.0;
}

double FitError::MeanPx(int view) const {
  const double all = view < 0 ? count.sum() : count.row(view).sum();
  const double sum = view < 0 ? sum_px.sum() : sum_px.row(view).sum();
  return all > 0.0 ? sum / all : 0.0;
}

FitGain CompareFits(const FitError& before, const FitError& after, int view) {
  FitGain gain;
  gain.before_px = before.MeanPx(view);
  gain.after_px = after.MeanPx(view);
  if (view >= 0) {
    gain.lasting_before_m = before.LastingM(static_cast<size_t>(view));
    gain.lasting_after_m = after.LastingM(static_cast<size_t>(view));
  }
  const RatioSeries series = SeriesOf(before, view);
  if (series.size() < 2) return gain;
  BootstrapOptions options;
  options.block_length = 2;  // bins
  options.resamples = 1000;
  const Interval interval =
      PairedInterval(PooledRatio, {series}, {SeriesOf(after, view)}, options);
  gain.low_px = interval.low;
  gain.high_px = interval.high;
  return gain;
}

CrossedGain CrossFit(const CameraRig& cameras, const SceneSegments& segments,
                     Halving halving, const FreeParameters& free,
                     const std::vector<CameraChange>& start,
                     const BundleOptions& options,
                     const std::vector<char>& moves) {
  BundleOptions changes_alone = options;
  changes_alone.wants_covariance = false;
  std::vector<FitError> before;
  std::vector<FitError> after;
  for (const int half : {0, 1}) {
    const SceneSegments other = HalfOf(segments, halving, 1 - half);
    const BundleResult result =
        AdjustBundle(cameras, HalfOf(segments, halving, half), free, start,
                     changes_alone, moves);
    before.push_back(MeasureFit(cameras, other, start, options.segments));
    after.push_back(MeasureFit(cameras, other,
                               result.usable ? result.changes : start,
                               options.segments));
  }
  const FitError all_before = Joined(before[0], before[1]);
  const FitError all_after = Joined(after[0], after[1]);
  CrossedGain gain;
  gain.all = CompareFits(all_before, all_after);
  for (size_t v = 0; v < cameras.size(); ++v) {
    gain.views.push_back(
        CompareFits(all_before, all_after, static_cast<int>(v)));
  }
  return gain;
}

}  // namespace kinegraph
