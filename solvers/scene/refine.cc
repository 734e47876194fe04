#include "solvers/scene/refine.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>
#include <utility>

#include "core/base/median.h"
#include "core/evaluation/statistics.h"
#include "solvers/scene/fit_terms.h"

namespace kinegraph {
namespace {

// A gain below this is not worth other cameras than those that were calibrated.
// A clock that is late is: whoever stands does not see it, and thins the gain.
constexpr double kLeastShareOfGain = 0.01;
// Groups that move together this much cannot be told apart.
constexpr double kMostCorrelation = 0.95;
// Fewer stretches leave chance too much room: a few hundred numbers of each
// view for up to nine of its camera.
constexpr size_t kLeastSegments = 60;

// The farthest that a clock is from the usual of all, their median [s].
double FarthestClock(const std::vector<CameraChange>& changes) {
  std::vector<double> offsets_s;
  offsets_s.reserve(changes.size());
  for (const CameraChange& one : changes) offsets_s.push_back(one[kOffsetAt]);
  const double usual_s = Median(offsets_s);
  double farthest_s = 0.0;
  for (const double offset_s : offsets_s) {
    farthest_s = std::max(farthest_s, std::abs(offset_s - usual_s));
  }
  return farthest_s;
}

// Under a sixth of a frame a clock hardly matters, and what walking people do
// to a detector's bias looks like it.
constexpr double kLeastLateFrames = 0.15;
constexpr double kLateSigmas = 4.0;

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

// What a fit states of its uncertainty.
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

// Fits, decides, and keeps what was worth it.
void Step(const CameraRig& cameras, const SceneSegments& segments,
          const FreeParameters& free, const std::string& what,
          const BundleOptions& options, Refinement* refinement) {
  RefineStep step;
  step.what = what;
  const auto gain_across = [&](Halving halving) {
    return CrossFit(cameras, segments, halving, free, refinement->changes,
                    options)
        .all;
  };
  step.gain = gain_across(Halving::kTime);
  const BundleResult result =
      AdjustBundle(cameras, segments, free, refinement->changes, options);
  if (!result.usable) {
    step.reason = "the solver found no solution";
  } else if (!step.gain.certain()) {
    step.reason = "the gain on the other half of the recording is not certain";
  } else if (step.gain.before_px - step.gain.after_px <
                 kLeastShareOfGain * step.gain.before_px &&
             !AnyIsLate(result, segments.frame_s, segments.span_s)) {
    step.reason = "the gain on the other half of the recording is below 1 %";
  } else if (!gain_across(Halving::kJoints).certain()) {
    step.reason = "the gain on the other half of the joints is not certain";
  } else {
    step.taken = true;
    refinement->changes = result.changes;
    StoreUncertainty(result, refinement);
  }
  refinement->steps.push_back(std::move(step));
}

// Clocks (the first step) and cameras (the second) once more, together, from
// where they are: what one took for the other is set right. Where they cannot
// be told apart the clocks stay as they were stated.
void StepTogether(const CameraRig& cameras, const SceneSegments& segments,
                  const FreeParameters& both, const BundleOptions& options,
                  Refinement* refinement) {
  const BundleResult result =
      AdjustBundle(cameras, segments, both, refinement->changes, options);
  refinement->largest_correlation = result.largest_correlation;
  if (!result.usable) return;
  if (result.largest_correlation <= kMostCorrelation) {
    refinement->changes = result.changes;
    StoreUncertainty(result, refinement);
    return;
  }
  for (size_t v = 0; v < cameras.size(); ++v) {
    for (const int place : {kOffsetAt, kDriftAt}) {
      refinement->changes[v][place] = refinement->sigmas[v][place] = 0.0;
    }
  }
  refinement->steps[0].taken = false;
  refinement->steps[0].reason =
      "clocks and cameras cannot be told apart in this recording";
}

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
         late * reach_s > kLeastLateFrames * frame_s &&
         late > kLateSigmas * sigma;
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

const std::vector<std::string>& RefineKindNames() {
  static const std::vector<std::string> kNames = {"off", "shift", "rotation",
                                                  "pose", "pose_focal"};
  return kNames;
}

const std::vector<std::string>& GroundKindNames() {
  static const std::vector<std::string> kNames = {"off", "feet"};
  return kNames;
}

void RefineOptions::Describe(OptionVisitor& visitor) {
  visitor.Choice("refine", &refine, RefineKindNames(),
                 "what is estimated of each camera from the people");
  visitor.Boolean("refine_clock", &refine_clock,
                  "estimate offset and drift of each view's clock");
  visitor.Choice("ground", &ground, GroundKindNames(),
                 "turn the world so that z points up from the floor on which "
                 "people stand");
}

FreeParameters CameraParametersOf(RefineKind kind) {
  FreeParameters free;
  free.shift = kind == RefineKind::kShift;
  free.rotation = kind == RefineKind::kRotation || kind == RefineKind::kPose ||
                  kind == RefineKind::kPoseFocal;
  free.centre = kind == RefineKind::kPose || kind == RefineKind::kPoseFocal;
  free.focal = kind == RefineKind::kPoseFocal;
  return free;
}

CrossedGain CrossFit(const CameraRig& cameras, const SceneSegments& segments,
                     Halving halving, const FreeParameters& free,
                     const std::vector<CameraChange>& start,
                     const BundleOptions& options,
                     const std::vector<char>& moves) {
  FitError before;
  FitError after;
  BundleOptions changes_alone = options;
  changes_alone.wants_covariance = false;
  for (const int half : {0, 1}) {
    const SceneSegments seen = HalfOf(segments, halving, half);
    const SceneSegments other = HalfOf(segments, halving, 1 - half);
    const BundleResult result =
        AdjustBundle(cameras, seen, free, start, changes_alone, moves);
    before.Append(MeasureFit(cameras, other, start, options.segments));
    after.Append(MeasureFit(cameras, other,
                            result.usable ? result.changes : start,
                            options.segments));
  }
  CrossedGain gain;
  gain.all = CompareFits(before, after);
  for (size_t v = 0; v < cameras.size(); ++v) {
    gain.views.push_back(CompareFits(before, after, static_cast<int>(v)));
  }
  return gain;
}

bool Refinement::any_taken() const {
  return std::any_of(steps.begin(), steps.end(),
                     [](const RefineStep& step) { return step.taken; });
}

Refinement RefineScene(const CameraRig& cameras,
                       const DetectionSequence& detections,
                       const FrozenMatches& matches,
                       const RefineOptions& options,
                       const BundleOptions& given) {
  Refinement refinement;
  refinement.changes.assign(cameras.size(), CameraChange::Zero());
  refinement.sigmas = refinement.changes;
  refinement.places.resize(cameras.size());
  const SceneSegments segments =
      MakeSegments(cameras, detections, matches, given.segments);
  const BundleOptions bundle = WithLastingErrors(given, segments);
  refinement.segments = static_cast<int64_t>(segments.segments.size());
  const bool enough = segments.segments.size() >= kLeastSegments;
  const FreeParameters clocks = ClockParametersOf(segments.span_s);
  const FreeParameters free = CameraParametersOf(options.refine);
  const auto step = [&](const FreeParameters& parameters,
                        const std::string& what) {
    if (enough) {
      Step(cameras, segments, parameters, what, bundle, &refinement);
    } else {
      refinement.steps.push_back(
          {what, /*taken=*/false, "too few matches", {}});
    }
  };
  refinement.hardly_moves = enough && !MoveEnough(segments);
  if (options.refine_clock && refinement.hardly_moves) {
    refinement.steps.push_back(
        {"clock",
         /*taken=*/false,
         "people hardly move, which tells nothing of clocks",
         {}});
  } else if (options.refine_clock) {
    step(clocks, "clock");
  }
  if (free.any_camera()) {
    step(free, RefineKindNames()[static_cast<size_t>(options.refine)]);
  }
  const bool both_taken =
      refinement.steps.size() == 2 &&
      std::all_of(refinement.steps.begin(), refinement.steps.end(),
                  [](const RefineStep& one) { return one.taken; });
  if (both_taken) {
    FreeParameters both = free;
    both.offset = clocks.offset;
    both.drift = clocks.drift;
    StepTogether(cameras, segments, both, bundle, &refinement);
  }
  if (FarthestClock(refinement.changes) <= kFarthestClockS) return refinement;
  RefineStep clock = refinement.steps.front();
  clock.taken = false;
  clock.reason = "clocks that are off by more than 0.1 s may be noise";
  RefineOptions cameras_alone = options;
  cameras_alone.refine_clock = false;
  refinement = RefineScene(cameras, detections, matches, cameras_alone, given);
  refinement.steps.insert(refinement.steps.begin(), std::move(clock));
  return refinement;
}

CameraRig RefinedCameras(const CameraRig& cameras,
                         const std::vector<CameraChange>& changes) {
  CameraRig rig;
  for (size_t v = 0; v < cameras.size(); ++v) {
    // What is not changed keeps its last bit.
    rig.push_back(changes[v].isZero(0.0)
                      ? cameras[v]
                      : ChangedCamera(cameras[v], changes[v]));
  }
  return rig;
}

DetectionSequence WithClocks(const DetectionSequence& detections,
                             const std::vector<CameraChange>& changes) {
  DetectionSequence moved = detections;
  const size_t frames = detections.frames.size();
  if (frames == 0) return moved;
  const TimeNs first = detections.frames.front().time;
  const TimeNs last = detections.frames.back().time;
  const TimeNs middle = first + (last - first) / 2;
  for (size_t v = 0; v < changes.size(); ++v) {
    const double offset_s = changes[v][kOffsetAt];
    const double drift = changes[v][kDriftAt];
    if (offset_s == 0.0 && drift == 0.0) continue;
    std::vector<TimeNs> nearest(frames);
    for (DetectionFrame& frame : moved.frames) {
      frame.views[v].detections.clear();
    }
    std::vector<char> taken(frames, 0);
    for (size_t k = 0; k < frames; ++k) {
      const ViewDetections& told = detections.frames[k].views[v];
      const double since = ToSeconds(told.capture_time - middle);
      const TimeNs capture =
          told.capture_time + FromSeconds(offset_s + drift * since);
      // The frame whose time is nearest.
      auto at = std::lower_bound(
          detections.frames.begin(), detections.frames.end(), capture,
          [](const DetectionFrame& f, TimeNs time) { return f.time < time; });
      if (at == detections.frames.end()) --at;
      if (at != detections.frames.begin() &&
          capture - std::prev(at)->time < at->time - capture) {
        --at;
      }
      const auto target = static_cast<size_t>(at - detections.frames.begin());
      const TimeNs off = std::abs(capture - at->time);
      if (taken[target] && off >= nearest[target]) continue;
      // Beyond the ends of the recording there is no frame to join.
      const TimeNs beat =
          frames > 1 ? (last - first) / static_cast<TimeNs>(frames - 1) : 0;
      if (off > beat) continue;
      taken[target] = 1;
      nearest[target] = off;
      moved.frames[target].views[v] = told;
      moved.frames[target].views[v].capture_time = capture;
    }
    for (size_t k = 0; k < frames; ++k) {
      if (!taken[k])
        moved.frames[k].views[v].capture_time = moved.frames[k].time;
    }
  }
  return moved;
}

BundleOptions WithLastingErrors(BundleOptions options,
                                const SceneSegments& segments) {
  const double factor = 1.0 / std::sqrt(std::max(1.0, SamplesAtOnce(segments)));
  options.rotation_sigma_rad *= factor;
  options.centre_sigma_m *= factor;
  options.shift_sigma_px *= factor;
  options.focal_sigma *= factor;
  return options;
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
