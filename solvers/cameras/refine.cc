#include "solvers/cameras/refine.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>
#include <utility>

#include "core/evaluation/statistics.h"
#include "solvers/cameras/left_out.h"

namespace kinegraph {
namespace {

// Names in the order of the enum.
std::vector<std::string> RefineKindNames() {
  return {"off", "shift", "rotation", "pose", "pose_focal"};
}

// Minimum gain for which calibrated cameras are replaced. It does not apply if
// a clock deviates (IsLate), because people at rest give no information about
// clocks and reduce the mean gain.
constexpr double kLeastShareOfGain = 0.01;
// Clocks and cameras that are more correlated than this count as
// indistinguishable.
constexpr double kMostCorrelation = 0.95;
// Minimum number of motion segments: a few hundred measurements per view for at
// most nine parameters of its camera and clock.
constexpr size_t kLeastSegments = 60;

// Minimum clock error in frames. Smaller errors hardly matter, and cannot be
// distinguished from a detector bias that depends on walking.
constexpr double kLeastLateFrames = 0.15;
constexpr double kLateSigmas = 4.0;

// Stores the covariance and sigmas of a fit.
void StoreUncertainty(const BundleResult& result, Refinement* refinement) {
  refinement->places = result.places;
  refinement->covariance = result.covariance;
  for (size_t v = 0; v < result.places.size(); ++v) {
    for (const int place : result.places[v]) {
      refinement->sigmas[v][place] = result.Sigma(v, place);
    }
  }
}

// Fits some parameters. Keeps the result if the gain is significant on the
// held-out halves of the recording and of the joints, and large enough
// (kLeastShareOfGain).
void TakeStep(const CameraRig& cameras, const SceneSegments& segments,
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
    step.reason =
        "the gain on the held-out half of the recording is not significant";
  } else if (step.gain.share() < kLeastShareOfGain &&
             !AnyIsLate(result, segments.frame_s, segments.span_s)) {
    step.reason = "the gain on the held-out half of the recording is below 1 %";
  } else if (!gain_across(Halving::kJoints).certain()) {
    step.reason =
        "the gain on the held-out half of the joints is not significant";
  } else {
    step.taken = true;
    refinement->changes = result.changes;
    StoreUncertainty(result, refinement);
  }
  refinement->steps.push_back(std::move(step));
}

// Fits clocks (the first step) and cameras (the second) jointly from their
// current values, which corrects errors of one that the other absorbed. If they
// are indistinguishable, the clocks are reset to their stated values.
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
      "clocks and cameras cannot be separated in this recording";
}

// Whether cameras excluded from the fit also show a significant gain, with the
// current clocks; true if there are too few cameras for this test.
bool HelpsOthers(const CameraRig& cameras, const SceneSegments& segments,
                 const FreeParameters& free, const BundleOptions& options,
                 const Refinement& refinement, RefineStep* step) {
  std::vector<CameraChange> stated(cameras.size(), CameraChange::Zero());
  for (size_t v = 0; v < cameras.size(); ++v) {
    for (const int place : {kOffsetAt, kDriftAt}) {
      stated[v][place] = refinement.changes[v][place];
    }
  }
  step->left_out = LeftOutGain(cameras, segments, free, stated, options);
  return !step->left_out.has_value() || step->left_out->certain();
}

// Mean number of samples of one person's joint in one view within a second,
// which count as one independent sample: a detector's error depends on the
// direction from which the body is seen, which hardly changes within a second.
double SamplesAtOnce(const SceneSegments& segments) {
  constexpr double kLastsS = 1.0;
  if (segments.segments.empty()) return 1.0;
  const double first_s = segments.segments.front().middle_s;
  using Sample =
      std::tuple<int, int, double, int>;  // person, joint, second, view
  std::set<Sample> distinct;
  double samples = 0.0;
  for (const MotionSegment& segment : segments.segments) {
    const double second = std::floor((segment.middle_s - first_s) / kLastsS);
    for (const SegmentMeasurement& one : segment.measurements) {
      distinct.emplace(segment.person, segment.joint, second, one.view_idx);
    }
    samples += static_cast<double>(segment.measurements.size());
  }
  return distinct.empty() ? 1.0
                          : samples / static_cast<double>(distinct.size());
}

// Segments of at least three frames also at low frame rates, as many as
// position, velocity and acceleration need. Three frames span two frame
// intervals, here with a tenth to spare.
SegmentOptions OfThreeFrames(SegmentOptions options,
                             const DetectionSequence& detections) {
  constexpr double kIntervals = 2.2;
  options.span_s = std::max(
      options.span_s, kIntervals * ToSeconds(FrameIntervalOf(detections)));
  return options;
}

// Whether any clock is farther from the median than motion segments can
// determine.
bool AnyIsFar(const std::vector<CameraChange>& changes, double farthest_s) {
  const double usual_s = UsualClock(changes, kOffsetAt);
  return std::any_of(changes.begin(), changes.end(),
                     [&](const CameraChange& one) {
                       return std::abs(one[kOffsetAt] - usual_s) > farthest_s;
                     });
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
  // The first view is the reference and has no sigma, so the second view's is
  // used.
  const double sigma = fit.Sigma(view == 0 ? 1 : view, place);
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

void RefineOptions::Describe(OptionVisitor& visitor) {
  visitor.Choice("refine", &refine, RefineKindNames(),
                 "camera parameters refined from the people");
  visitor.Boolean("refine_clock", &refine_clock,
                  "estimate offset and drift of each view's clock");
  visitor.Choice("ground", &ground, {"off", "feet"},
                 "transform the world so that z points up from the floor on "
                 "which people stand");
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
  BundleOptions bundle = given;
  bundle.segments = OfThreeFrames(given.segments, detections);
  const SceneSegments segments =
      MakeSegments(cameras, detections, matches, bundle.segments);
  bundle = WithLastingErrors(bundle, segments);
  refinement.segments = static_cast<int64_t>(segments.segments.size());
  const bool enough = segments.segments.size() >= kLeastSegments;
  const FreeParameters clocks = ClockParametersOf(segments.span_s);
  const FreeParameters free = CameraParametersOf(options.refine);
  const auto step = [&](const FreeParameters& parameters,
                        const std::string& what) {
    if (enough) {
      TakeStep(cameras, segments, parameters, what, bundle, &refinement);
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
         "people hardly move, which gives no information about clocks",
         {}});
  } else if (options.refine_clock) {
    step(clocks, "clock");
  }
  const Refinement clocks_alone = refinement;
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
  // Tested last, because the fit in excluded cameras may improve only if clocks
  // and cameras are corrected together.
  if (free.any_camera() && refinement.steps.back().taken &&
      !HelpsOthers(cameras, segments, free, bundle, refinement,
                   &refinement.steps.back())) {
    RefineStep refused = std::move(refinement.steps.back());
    refused.taken = false;
    refused.reason = "cameras excluded from the fit show no significant gain";
    refinement = clocks_alone;
    refinement.steps.push_back(std::move(refused));
  }
  const double farthest_s =
      std::max(kFarthestClockS, 0.5 * bundle.segments.span_s);
  if (!AnyIsFar(refinement.changes, farthest_s)) return refinement;
  RefineStep clock = refinement.steps.front();
  clock.taken = false;
  clock.reason = fmt::format(
      "estimated clock errors of more than {:.2g} s may be noise", farthest_s);
  RefineOptions cameras_alone = options;
  cameras_alone.refine_clock = false;
  refinement = RefineScene(cameras, detections, matches, cameras_alone, given);
  refinement.steps.insert(refinement.steps.begin(), std::move(clock));
  return refinement;
}

DetectionSequence WithClocks(const DetectionSequence& detections,
                             const std::vector<CameraChange>& changes) {
  const std::vector<DetectionFrame>& frames = detections.frames;
  DetectionSequence moved = detections;
  if (frames.empty()) return moved;
  const TimeNs first = frames.front().time;
  const TimeNs last = frames.back().time;
  const TimeNs middle = first + (last - first) / 2;
  const auto intervals = static_cast<TimeNs>(frames.size()) - 1;
  const TimeNs interval = intervals > 0 ? (last - first) / intervals : 0;
  for (size_t v = 0; v < changes.size(); ++v) {
    const double offset_s = changes[v][kOffsetAt];
    const double drift = changes[v][kDriftAt];
    if (offset_s == 0.0 && drift == 0.0) continue;
    for (DetectionFrame& frame : moved.frames) {
      frame.views[v].detections.clear();
      frame.views[v].capture_time = frame.time;
    }
    // The least distance so far of a capture from each frame.
    std::vector<TimeNs> nearest(frames.size(), interval + 1);
    for (const DetectionFrame& frame : frames) {
      const ViewDetections& recorded = frame.views[v];
      const TimeNs capture =
          recorded.capture_time +
          FromSeconds(offset_s +
                      drift * ToSeconds(recorded.capture_time - middle));
      // The frame whose time is nearest, at most one frame interval away.
      auto at = std::lower_bound(
          frames.begin(), frames.end(), capture,
          [](const DetectionFrame& f, TimeNs time) { return f.time < time; });
      if (at == frames.end()) --at;
      if (at != frames.begin() &&
          capture - std::prev(at)->time < at->time - capture) {
        --at;
      }
      const auto target = static_cast<size_t>(at - frames.begin());
      const TimeNs off = std::abs(capture - at->time);
      if (off >= nearest[target]) continue;
      nearest[target] = off;
      moved.frames[target].views[v] = recorded;
      moved.frames[target].views[v].capture_time = capture;
    }
  }
  return moved;
}

BundleOptions WithLastingErrors(BundleOptions options,
                                const SceneSegments& segments) {
  options.samples_at_once = std::max(1.0, SamplesAtOnce(segments));
  return options;
}

void RefineAgain(const CameraRig& cameras, const DetectionSequence& detections,
                 const FrozenMatches& matches, const BundleOptions& bundle,
                 Refinement* refinement) {
  std::vector<int> taken;  // parameters refined in any view
  for (const std::vector<int>& places : refinement->places) {
    taken.insert(taken.end(), places.begin(), places.end());
  }
  const FreeParameters free = FreeParameters::At(taken);
  std::vector<CameraChange> start = refinement->changes;
  for (CameraChange& change : start) {
    // Already applied to the detections.
    change[kOffsetAt] = change[kDriftAt] = 0.0;
  }
  // A single fit, unlike the many fits of the decisions, can afford more
  // segments.
  constexpr int kTimesMore = 4;
  BundleOptions more = bundle;
  more.segments = OfThreeFrames(bundle.segments, detections);
  more.segments.max_segments *= kTimesMore;
  const SceneSegments segments = MakeSegments(
      RefinedCameras(cameras, start), detections, matches, more.segments);
  const BundleResult result = AdjustBundle(cameras, segments, free, start,
                                           WithLastingErrors(more, segments));
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
