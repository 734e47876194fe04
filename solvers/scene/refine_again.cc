#include "solvers/scene/refine_again.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>
#include <vector>

namespace kinegraph {
namespace {

// Samples that say the same: of a view, of one joint, within a second, in the
// mean. What a detector adds depends on where the body is seen from, which
// hardly changes in less.
double SamplesAtOnce(const SceneSegments& segments) {
  constexpr double kLastsS = 1.0;
  if (segments.segments.empty()) return 1.0;
  const double first_s = segments.segments.front().middle_s;
  using Said =
      std::tuple<int, int, double, int>;  // person, joint, second, view
  std::set<Said> said;
  double samples = 0.0;
  for (const MotionSegment& segment : segments.segments) {
    const double second = std::floor((segment.middle_s - first_s) / kLastsS);
    for (const SegmentMeasurement& one : segment.measurements) {
      said.emplace(segment.person, segment.joint, second, one.view_idx);
    }
    samples += static_cast<double>(segment.measurements.size());
  }
  return said.empty() ? 1.0 : samples / static_cast<double>(said.size());
}

FreeParameters TakenOf(const Refinement& refinement,
                       const RefineOptions& options) {
  FreeParameters free;
  for (const RefineStep& step : refinement.steps) {
    if (!step.taken) continue;
    if (step.what == "clock") {
      free.offset = true;
      for (const CameraChange& sigma : refinement.sigmas) {
        free.drift = free.drift || sigma[kDriftAt] > 0.0;
      }
    } else {
      const FreeParameters camera = CameraParametersOf(options.refine);
      free.shift = camera.shift;
      free.rotation = camera.rotation;
      free.centre = camera.centre;
      free.focal = camera.focal;
    }
  }
  return free;
}

}  // namespace

BundleOptions WithLastingErrors(BundleOptions options,
                                const SceneSegments& segments) {
  const double factor = 1.0 / std::sqrt(std::max(1.0, SamplesAtOnce(segments)));
  options.rotation_sigma_rad *= factor;
  options.centre_sigma_m *= factor;
  options.shift_sigma_px *= factor;
  options.focal_sigma *= factor;
  return options;
}

void StoreUncertainty(const BundleResult& result, Refinement* refinement) {
  refinement->places = result.places;
  refinement->covariance = result.covariance;
  Eigen::Index at = 0;
  for (size_t v = 0; v < result.places.size(); ++v) {
    for (const int place : result.places[v]) {
      refinement->sigmas[v][place] =
          std::sqrt(std::max(0.0, result.covariance(at, at)));
      ++at;
    }
  }
}

void RefineAgain(const CameraRig& cameras, const DetectionSequence& detections,
                 const FrozenMatches& matches, const RefineOptions& options,
                 const BundleOptions& bundle, Refinement* refinement) {
  const FreeParameters free = TakenOf(*refinement, options);
  std::vector<CameraChange> start = refinement->changes;
  for (CameraChange& change : start) {
    change[kOffsetAt] = change[kDriftAt] = 0.0;  // the detections have them
  }
  // One fit instead of the decisions' many: it can afford more of the
  // recording.
  constexpr int kTimesMore = 4;
  SegmentOptions more = bundle.segments;
  more.max_segments *= kTimesMore;
  const SceneSegments segments =
      MakeSegments(RefinedCameras(cameras, start), detections, matches, more);
  const BundleResult result = AdjustBundle(cameras, segments, free, start,
                                           WithLastingErrors(bundle, segments));
  if (!result.usable) return;
  refinement->segments = static_cast<int64_t>(segments.segments.size());
  for (size_t v = 0; v < cameras.size(); ++v) {
    CameraChange change = result.changes[v];
    change[kOffsetAt] += refinement->changes[v][kOffsetAt];
    change[kDriftAt] += refinement->changes[v][kDriftAt];
    refinement->changes[v] = change;
  }
  StoreUncertainty(result, refinement);
}

}  // namespace kinegraph
