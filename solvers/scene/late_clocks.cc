#include "solvers/scene/late_clocks.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/evaluation/statistics.h"
#include "solvers/scene/fit_terms.h"

namespace kinegraph {
namespace {

// Under a sixth of a frame a clock hardly matters, and what walking people do
// to a detector's bias looks like it.
constexpr double kLeastFrames = 0.15;
constexpr double kSigmas = 4.0;

// Standard deviation of a view's offset or drift; the first view, which has
// none of its own, has the second one's. 0 where it was not estimated.
double ClockSigma(const BundleResult& fit, size_t view, int place) {
  const size_t wanted = view == 0 ? 1 : view;
  Eigen::Index at = 0;
  for (size_t v = 0; v < fit.places.size(); ++v) {
    for (const int one : fit.places[v]) {
      if (v == wanted && one == place) {
        return std::sqrt(std::max(0.0, fit.covariance(at, at)));
      }
      ++at;
    }
  }
  return 0.0;
}

}  // namespace

double UsualClock(const std::vector<CameraChange>& changes, int place) {
  std::vector<double> values;
  values.reserve(changes.size());
  for (const CameraChange& change : changes) values.push_back(change[place]);
  return Quantile(std::move(values), 0.5);
}

bool IsLate(const BundleResult& fit, size_t view, int place, double frame_s,
            double span_s) {
  const double sigma = ClockSigma(fit, view, place);
  if (!(sigma > 0.0)) return false;
  const double reach_s = place == kDriftAt ? span_s : 1.0;
  const double late =
      std::abs(fit.changes[view][place] - UsualClock(fit.changes, place));
  return late * reach_s < kFarthestClockS &&
         late * reach_s > kLeastFrames * frame_s && late > kSigmas * sigma;
}

bool AnyIsLate(const BundleResult& fit, double frame_s, double span_s) {
  for (size_t v = 0; v < fit.changes.size(); ++v) {
    if (IsLate(fit, v, kOffsetAt, frame_s, span_s) ||
        IsLate(fit, v, kDriftAt, frame_s, span_s)) {
      return true;
    }
  }
  return false;
}

}  // namespace kinegraph
