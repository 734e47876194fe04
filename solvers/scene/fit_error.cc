#include "solvers/scene/fit_error.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/evaluation/bootstrap.h"

namespace kinegraph {
namespace {

// The place of each segment's bin of time among those that hold any, however
// long the clock stands still in between.
std::vector<size_t> SegmentBins(const SceneSegments& segments, size_t* count) {
  double first = segments.segments.front().middle_s;
  for (const MotionSegment& segment : segments.segments) {
    first = std::min(first, segment.middle_s);
  }
  const double bin_s = BinLength(segments);
  std::vector<double> bins;
  for (const MotionSegment& segment : segments.segments) {
    bins.push_back(std::floor((segment.middle_s - first) / bin_s));
  }
  std::vector<double> held = bins;
  std::sort(held.begin(), held.end());
  held.erase(std::unique(held.begin(), held.end()), held.end());
  *count = held.size();
  std::vector<size_t> places;
  for (const double bin : bins) {
    const auto at = std::lower_bound(held.begin(), held.end(), bin);
    places.push_back(static_cast<size_t>(at - held.begin()));
  }
  return places;
}

}  // namespace

FitError MeasureFit(const CameraRig& cameras, const SceneSegments& segments,
                    const std::vector<CameraChange>& changes,
                    const SegmentOptions& options, double cap_px) {
  FitError error;
  if (segments.segments.empty()) return error;
  size_t bins = 0;
  const std::vector<size_t> bin_of = SegmentBins(segments, &bins);
  error.sum_px.assign(cameras.size(), std::vector<double>(bins, 0.0));
  error.count = error.sum_px;
  error.lasting_m.assign(cameras.size(), 0.0);
  error.segments = error.lasting_m;
  std::vector<Eigen::Vector3d> sums(cameras.size());  // x, y, count
  for (size_t s = 0; s < segments.segments.size(); ++s) {
    const MotionSegment& segment = segments.segments[s];
    SegmentState state = segment.state;
    const bool solved = SolveSegment(cameras, changes, segment,
                                     segments.noise_scale, options, &state);
    std::fill(sums.begin(), sums.end(), Eigen::Vector3d::Zero());
    for (const SegmentMeasurement& measurement : segment.measurements) {
      const auto v = static_cast<size_t>(measurement.view_idx);
      double distance_px = cap_px;
      if (solved) {
        const auto r = SegmentResidual(cameras[v], changes[v], segment, state,
                                       measurement, 1.0, nullptr, nullptr);
        if (r.has_value()) {
          const Eigen::Vector2d residual_px = *r * measurement.sigma_px;
          distance_px = std::min(cap_px, residual_px.norm());
          const double cap = distance_px / std::max(1e-9, residual_px.norm());
          sums[v] += Eigen::Vector3d(cap * residual_px.x(),
                                     cap * residual_px.y(), 1.0);
        }
      }
      error.sum_px[v][bin_of[s]] += distance_px;
      error.count[v][bin_of[s]] += 1.0;
    }
    const Eigen::Vector3d place = PositionOf(segment);
    for (size_t v = 0; v < cameras.size(); ++v) {
      if (sums[v].z() == 0.0) continue;
      error.lasting_m[v] += sums[v].head<2>().norm() / sums[v].z() *
                            cameras[v].Depth(place) / cameras[v].focal_px();
      error.segments[v] += 1.0;
    }
  }
  return error;
}

double FitError::LastingM(size_t view) const {
  return view < segments.size() && segments[view] > 0.0
             ? lasting_m[view] / segments[view]
             : 0.0;
}

void FitError::Append(const FitError& other) {
  if (sum_px.empty()) {
    *this = other;
    return;
  }
  for (size_t v = 0; v < other.sum_px.size(); ++v) {
    lasting_m[v] += other.lasting_m[v];
    segments[v] += other.segments[v];
    sum_px[v].insert(sum_px[v].end(), other.sum_px[v].begin(),
                     other.sum_px[v].end());
    count[v].insert(count[v].end(), other.count[v].begin(),
                    other.count[v].end());
  }
}

double FitError::MeanPx() const {
  double sum = 0.0;
  double all = 0.0;
  for (size_t v = 0; v < sum_px.size(); ++v) {
    for (size_t s = 0; s < sum_px[v].size(); ++s) {
      sum += sum_px[v][s];
      all += count[v][s];
    }
  }
  return all > 0.0 ? sum / all : 0.0;
}

double FitError::MeanPx(int view) const {
  double sum = 0.0;
  double all = 0.0;
  const auto v = static_cast<size_t>(view);
  for (size_t s = 0; v < sum_px.size() && s < sum_px[v].size(); ++s) {
    sum += sum_px[v][s];
    all += count[v][s];
  }
  return all > 0.0 ? sum / all : 0.0;
}

FitGain CompareFits(const FitError& before, const FitError& after, int view) {
  FitGain gain;
  gain.before_px = view < 0 ? before.MeanPx() : before.MeanPx(view);
  gain.after_px = view < 0 ? after.MeanPx() : after.MeanPx(view);
  if (view >= 0) {
    gain.lasting_before_m = before.LastingM(static_cast<size_t>(view));
    gain.lasting_after_m = after.LastingM(static_cast<size_t>(view));
  }
  RatioSeries series_before;
  RatioSeries series_after;
  const size_t bins = before.sum_px.empty() ? 0 : before.sum_px[0].size();
  for (size_t s = 0; s < bins; ++s) {
    RatioUnit unit_before;
    RatioUnit unit_after;
    for (size_t v = 0; v < before.sum_px.size(); ++v) {
      if (view >= 0 && v != static_cast<size_t>(view)) continue;
      unit_before.sum += before.sum_px[v][s];
      unit_before.weight += before.count[v][s];
      unit_after.sum += after.sum_px[v][s];
      unit_after.weight += after.count[v][s];
    }
    if (!(unit_before.weight > 0.0)) continue;
    series_before.push_back(unit_before);
    series_after.push_back(unit_after);
  }
  if (series_before.size() < 2) return gain;
  BootstrapOptions options;
  options.block_length = 2;  // bins
  options.resamples = 1000;
  const Interval interval =
      PairedPooledInterval({series_before}, {series_after}, options);
  gain.low_px = interval.low;
  gain.high_px = interval.high;
  return gain;
}

}  // namespace kinegraph
