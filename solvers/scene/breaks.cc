// Changes in the middle of a recording: images that a view lost or duplicated,
// after which its clock is off by whole frames, and a camera that was moved,
// whose view then agrees less with the others.
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "core/base/text.h"
#include "solvers/cameras/bundle.h"
#include "solvers/scene/clock_search.h"
#include "solvers/scene/hypothesis.h"
#include "solvers/scene/plausible.h"

namespace kinegraph {
namespace {

// ---- A step in a series ----

// Information of a time bin about a level, and the gradient of half the squared
// error at level 0; the estimate is -gradient / information.
struct LevelBin {
  double time_s = 0.0;
  double information = 0.0;
  double gradient = 0.0;
};
using LevelBins = std::vector<LevelBin>;

LevelBin SumOf(const LevelBins& bins, size_t begin, size_t end) {
  LevelBin sum;
  for (size_t b = begin; b < end; ++b) {
    sum.information += bins[b].information;
    sum.gradient += bins[b].gradient;
  }
  return sum;
}

struct Step {
  size_t bin = 0;  // the first bin after the step
  double before = 0.0;
  double after = 0.0;
  double sigma = 0.0;  // of the difference
  // Reduction of the squared error relative to a straight line, in units of the
  // scatter (StepAt).
  double gain = 0.0;
  double size() const { return std::abs(after - before); }
};

// Reduction of the squared error by a straight line.
double GainOfLine(const LevelBins& bins) {
  Eigen::Matrix2d H = Eigen::Matrix2d::Zero();
  Eigen::Vector2d g = Eigen::Vector2d::Zero();
  for (const LevelBin& bin : bins) {
    const Eigen::Vector2d row(1.0, bin.time_s);
    H += bin.information * row * row.transpose();
    g += bin.gradient * row;
  }
  return g.dot(H.ldlt().solve(g));
}

Step StepAt(const LevelBins& bins, size_t at, double least_scatter) {
  const LevelBin before = SumOf(bins, 0, at);
  const LevelBin after = SumOf(bins, at, bins.size());
  Step step;
  step.bin = at;
  step.before = -before.gradient / before.information;
  step.after = -after.gradient / after.information;
  // Ratio of the scatter of the bins about the two levels to the scatter
  // expected from their information; often above 1, because a detector's errors
  // are correlated in time.
  double squares = 0.0;
  double count = 0.0;
  for (size_t b = 0; b < bins.size(); ++b) {
    if (!(bins[b].information > 0.0)) continue;
    const double level = b < at ? step.before : step.after;
    const double left = bins[b].gradient + bins[b].information * level;
    squares += left * left / bins[b].information;
    count += 1.0;
  }
  const double scatter =
      std::max(least_scatter, squares / std::max(1.0, count - 3.0));
  step.sigma =
      std::sqrt(scatter * (1.0 / before.information + 1.0 / after.information));
  const auto gain = [](const LevelBin& sum) {
    return sum.gradient * sum.gradient / sum.information;
  };
  step.gain = (gain(before) + gain(after) - GainOfLine(bins)) / scatter;
  return step;
}

// All steps with at least three non-empty bins on either side.
std::vector<Step> StepsOf(const LevelBins& bins, double least_scatter) {
  constexpr std::ptrdiff_t kFewestBins = 3;
  const auto is_full = [](const LevelBin& bin) {
    return bin.information > 0.0;
  };
  std::vector<Step> steps;
  for (auto at = bins.begin(); at != bins.end(); ++at) {
    if (std::count_if(bins.begin(), at, is_full) >= kFewestBins &&
        std::count_if(at, bins.end(), is_full) >= kFewestBins) {
      steps.push_back(
          StepAt(bins, static_cast<size_t>(at - bins.begin()), least_scatter));
    }
  }
  return steps;
}

// ---- Images lost or duplicated ----

struct ClockJump {
  size_t view = 0;
  double at_s = 0.0;  // since the middle of the recording
  // Number of images missing before `at_s`; negative: too many.
  int missing = 0;
  double jump_s = 0.0;   // as measured
  double sigma_s = 0.0;  // its standard deviation
};

// Estimates of each view's offset by time bin, assuming that the other views
// are correct. A bin is a fortieth of the recording, but at least half a
// second, the duration of a footstep.
std::vector<LevelBins> OffsetBins(const CameraRig& cameras,
                                  const SceneSegments& segments,
                                  const SegmentOptions& options) {
  const std::vector<CameraChange> none = NoChanges(cameras.size());
  const double length_s = std::max(0.5, segments.span_s / 40.0);
  const double first_s = -0.5 * segments.span_s;
  const auto count =
      static_cast<size_t>(std::ceil(segments.span_s / length_s)) + 1;
  std::vector<ReducedSystem> systems(
      count, ReducedSystem(cameras, segments, {cameras.size(), {kOffsetAt}},
                           PriorInformation(options)));
  for (const MotionSegment& segment : segments.segments) {
    SegmentState state = segment.state;
    if (!SolveSegment(cameras, none, segment, segments.noise_scale, options,
                      &state)) {
      continue;
    }
    const double bin = std::max(0.0, (segment.middle_s - first_s) / length_s);
    systems[std::min(count - 1, static_cast<size_t>(bin))].Add(segment, state,
                                                               none);
  }
  std::vector<LevelBins> bins(cameras.size());
  for (size_t b = 0; b < count; ++b) {
    const double time_s = first_s + (static_cast<double>(b) + 0.5) * length_s;
    const Eigen::VectorXd gradient = systems[b].Gradient();
    for (size_t v = 0; v < cameras.size(); ++v) {
      const auto i = static_cast<Eigen::Index>(v);
      bins[v].push_back({time_s, systems[b].information()(i, i), gradient[i]});
    }
  }
  return bins;
}

// The segments with the view's clock shifted after the jump.
SceneSegments Moved(const SceneSegments& segments, const ClockJump& jump) {
  SceneSegments moved = segments;
  for (MotionSegment& segment : moved.segments) {
    if (segment.middle_s < jump.at_s) continue;
    for (SegmentMeasurement& measurement : segment.measurements) {
      if (measurement.view_idx == static_cast<int>(jump.view)) {
        measurement.time_s += jump.jump_s;
      }
    }
  }
  return moved;
}

// The clearest jump of one view's clock, or nullopt. For each view the clock's
// offset is estimated in short time bins (Gauss-Newton steps on the segments
// with their states eliminated, assuming that the other views are correct). A
// jump is modelled as two levels that explain the bins better than offset and
// drift; their difference is rounded to whole frames.
std::optional<ClockJump> FindClockJump(const SetUp& set_up) {
  // Six standard deviations, because about forty splits of several views are
  // tested. A step that a drift explains nearly as well is rejected.
  constexpr double kSigmas = 6.0;
  constexpr double kLeastGain = 25.0;
  const double frame_s = 1.0 / std::max(1.0, set_up.rate_hz);
  const auto bins_of = [&](const SceneSegments& segments) {
    return OffsetBins(set_up.cameras, segments, set_up.options.bundle.segments);
  };
  const std::vector<LevelBins> all = bins_of(set_up.segments);
  ClockJump jump;
  Step best;
  best.gain = kLeastGain;
  for (size_t v = 0; v < all.size(); ++v) {
    for (const Step& step : StepsOf(all[v], 1.0)) {
      if (!(step.gain > best.gain) || step.size() < 0.3 * frame_s ||
          step.size() < kSigmas * step.sigma) {
        continue;
      }
      best = step;
      jump.view = v;
      jump.at_s = 0.5 * (all[v][step.bin - 1].time_s + all[v][step.bin].time_s);
    }
  }
  if (best.bin == 0) return std::nullopt;
  jump.jump_s = best.after - best.before;
  jump.sigma_s = best.sigma;
  // One Gauss-Newton step underestimates the jump, because the states and the
  // loss absorb part of the error.
  constexpr int kMostSteps = 6;
  for (int round = 0; round < kMostSteps; ++round) {
    const Step left =
        StepAt(bins_of(Moved(set_up.segments, jump))[jump.view], best.bin, 1.0);
    jump.jump_s += left.after - left.before;
    if (left.size() < 0.05 * frame_s) break;
  }
  jump.missing = static_cast<int>(std::lround(jump.jump_s / frame_s));
  if (jump.missing == 0) return std::nullopt;
  return jump;
}

// The detections without the jump: the view's images from index `from` on are
// shifted by the number of missing images.
DetectionSequence WithoutJump(const DetectionSequence& detections,
                              const ClockJump& jump, int64_t from) {
  return FramesMoved(detections, [&](size_t view, int64_t k) -> int64_t {
    if (view != jump.view || k < std::min(from, from + jump.missing)) return k;
    return k - jump.missing >= from ? k - jump.missing : -1;
  });
}

// Index of the first frame at or after a time relative to the middle of the
// recording.
int64_t IndexAfter(const std::vector<DetectionFrame>& frames, double at_s) {
  const TimeNs middle =
      frames.front().time + (frames.back().time - frames.front().time) / 2;
  const auto at = std::lower_bound(
      frames.begin(), frames.end(), middle + FromSeconds(at_s),
      [](const DetectionFrame& f, TimeNs time) { return f.time < time; });
  return at - frames.begin();
}

Finding FindingOf(const ClockJump& jump, const std::string& camera,
                  int64_t frame, int64_t number_step, double before_px,
                  double after_px) {
  const int count = std::abs(jump.missing);
  const bool lost = jump.missing > 0;
  return {"frames",
          camera,
          0.9,
          before_px,
          after_px,
          lost ? fmt::format("from about frame {} on, increase the frame "
                             "numbers of its files by {}",
                             frame, count * number_step)
               : fmt::format("remove {} before about frame {}",
                             Counted(count, "image", "images"), frame),
          fmt::format("{} {} before about frame {}: its clock jumps by "
                      "{:+.1f} +- {:.1f} ms",
                      Counted(count, "image is", "images are"),
                      lost ? "missing" : "in excess", frame, 1e3 * jump.jump_s,
                      1e3 * jump.sigma_s)};
}

// ---- A camera that was moved ----

struct CameraBreak {
  size_t view = 0;
  size_t from = 0;  // index of the first frame after the move
  // Agreement of the view with the others (PairAgreement), minus the agreement
  // of the others among themselves, before and after.
  double before = 0.0;
  double after = 0.0;

  bool worse_after() const { return after < before; }
};

// The agreement of a view with the others, and of the others among themselves,
// over some frames.
struct OwnAndOthers {
  PairAgreement own;
  PairAgreement others;

  void Add(const OwnAndOthers& more) {
    own.Add(more.own);
    others.Add(more.others);
  }
  bool known() const { return own.possible > 0.0 && others.possible > 0.0; }
  double level() const { return own.score() - others.score(); }
};

// [view][frame examined]
std::vector<std::vector<OwnAndOthers>> LookAtFrames(
    const CameraRig& cameras, const std::vector<ViewPeople>& ideal,
    const std::vector<int>& frames) {
  const size_t views = cameras.size();
  std::vector<std::vector<OwnAndOthers>> all(
      views, std::vector<OwnAndOthers>(frames.size()));
  for (size_t i = 0; i < frames.size(); ++i) {
    for (const auto& [a, b] : ComparedPairs(views)) {
      const PairAgreement pair =
          AgreementOf(cameras[a], ideal[a], cameras[b], ideal[b], {frames[i]});
      for (size_t v = 0; v < views; ++v) {
        (v == a || v == b ? all[v][i].own : all[v][i].others).Add(pair);
      }
    }
  }
  return all;
}

// A view's levels in bins of consecutive frames; a bin's time is the index of
// its first examined frame.
LevelBins BinsOf(const std::vector<OwnAndOthers>& frames, size_t count) {
  LevelBins bins;
  for (size_t b = 0; b < count; ++b) {
    const size_t begin = frames.size() * b / count;
    const size_t end = frames.size() * (b + 1) / count;
    OwnAndOthers sum;
    for (size_t i = begin; i < end; ++i) sum.Add(frames[i]);
    if (!sum.known()) continue;
    bins.push_back({static_cast<double>(begin), 1.0, -sum.level()});
  }
  return bins;
}

// Index in `frames` of the first frame after a step of the bins: among the
// frames of the two bins at the step, the one that best divides levels above
// and below the mean of the two levels.
size_t FrameOf(const std::vector<OwnAndOthers>& frames, const LevelBins& bins,
               const Step& step) {
  const size_t begin = static_cast<size_t>(bins[step.bin - 1].time_s);
  const size_t end = step.bin + 1 < bins.size()
                         ? static_cast<size_t>(bins[step.bin + 1].time_s)
                         : frames.size();
  const double middle = 0.5 * (step.before + step.after);
  const double sign = step.after < step.before ? 1.0 : -1.0;
  double sum = 0.0;
  double most = 0.0;
  size_t best = begin;
  for (size_t i = begin; i < end; ++i) {
    if (frames[i].known()) sum += sign * (frames[i].level() - middle);
    if (sum > most) {
      most = sum;
      best = i + 1;
    }
  }
  return best;
}

// The clearest break, or nullopt: a step in one view's agreement over the
// frames. With fewer than three views it cannot be attributed to a view. A lost
// image has the same effect on the agreement.
std::optional<CameraBreak> FindCameraBreak(
    const CameraRig& cameras, const std::vector<ViewPeople>& ideal,
    const DetectionSequence& detections) {
  // People who arrive, leave or occlude each other also change the level.
  constexpr double kLeastStep = 0.04;
  constexpr double kSigmas = 5.0;
  constexpr int kMostFrames = 400;
  constexpr double kBinS = 0.5;  // the duration of a footstep
  constexpr size_t kMostBins = 40;
  if (cameras.size() < 3 || detections.frames.empty()) return std::nullopt;
  const std::vector<int> frames = FramesToLookAt(ideal, kMostFrames);
  const double span_s =
      ToSeconds(detections.frames.back().time - detections.frames.front().time);
  const size_t count =
      std::min({static_cast<size_t>(span_s / kBinS), frames.size(), kMostBins});
  const auto all = LookAtFrames(cameras, ideal, frames);
  std::optional<CameraBreak> found;
  for (size_t v = 0; v < all.size(); ++v) {
    const LevelBins bins = BinsOf(all[v], count);
    Step best;  // the most significant step
    for (const Step& step : StepsOf(bins, 1e-12)) {
      if (best.bin == 0 ||
          step.size() * best.sigma > best.size() * step.sigma) {
        best = step;
      }
    }
    if (best.bin == 0 || best.size() < kSigmas * best.sigma ||
        best.size() < kLeastStep ||
        (found.has_value() &&
         best.size() <= std::abs(found->after - found->before))) {
      continue;
    }
    const size_t at = std::min(FrameOf(all[v], bins, best), frames.size() - 1);
    found = CameraBreak{v, static_cast<size_t>(frames[at]), best.before,
                        best.after};
  }
  return found;
}

// The frames before `from` (side 0) or from it on (side 1).
DetectionSequence SideOf(const DetectionSequence& detections, size_t from,
                         int side) {
  DetectionSequence part;
  part.header = detections.header;
  const auto middle =
      detections.frames.begin() + static_cast<std::ptrdiff_t>(from);
  part.frames.assign(side == 0 ? detections.frames.begin() : middle,
                     side == 0 ? middle : detections.frames.end());
  return part;
}

// Whether a lag makes the worse side nearly as good as the other. If so, images
// were lost, which is examined later.
bool IsLag(const SetUp& set_up, const CameraBreak& found, int worse) {
  constexpr double kNearly = 0.05;  // of agreement
  const auto ideal_of = [&](int side) {
    return IdealPeople(SideOf(set_up.detections, found.from, side),
                       set_up.cameras);
  };
  const ClockSearch lags =
      SearchClocks(set_up.cameras, ideal_of(worse), set_up.LongestLag());
  if (!lags.found()) return false;
  const std::vector<ViewPeople> better = ideal_of(1 - worse);
  const double score = AgreementOfAll(set_up.cameras, better,
                                      FramesToLookAt(better, kFramesToLookAt))
                           .score();
  return lags.all.after.score() > score - kNearly;
}

Diagnosis DiagnosePart(const SetUp& set_up, DetectionSequence part) {
  DoctorInput input = set_up.input;
  input.cameras = set_up.NamedCameras();
  input.detections = std::move(part);
  DoctorOptions options = set_up.options;
  options.looks_for_break = false;
  options.longest_lag_s = 0.0;
  return Diagnose(input, options);
}

// Rewrites a finding about one side as a finding about the whole recording.
Finding OfSide(const SetUp& set_up, const CameraBreak& found, Finding finding) {
  const auto& frames = set_up.detections.frames;
  const int64_t from = frames[found.from].frame;
  const bool after = found.worse_after();
  std::string side = fmt::format("--frames={}:{}", frames.front().frame, from);
  std::string other =
      fmt::format("--frames={}:{}", from, frames.back().frame + 1);
  if (after) std::swap(side, other);
  finding.fix =
      finding.kind == "never_matched"
          ? side + " " + finding.fix
          : "kinegraph doctor INPUTS " + side + " --out=doctor_of_these";
  finding.evidence = fmt::format(
      "{} about frame {}{}: {}; the camera was moved during the recording: "
      "track the two parts separately: one with {} and the calibration as it "
      "is, the other with the stated fix (if that is a doctor command, with "
      "the cameras.json it writes)",
      after ? "from" : "before", from, after ? " on" : "", finding.evidence,
      other);
  return finding;
}

}  // namespace

// A jump is accepted if correcting it reduces the view's residuals by
// FitGain::kLeastShare or more, and if it is still found after refining the
// orientation of the cameras: if people turn round, a wrongly oriented camera
// seems to lag for a while.
std::optional<Answer> AskForJump(const SetUp& set_up) {
  if (!MoveEnough(set_up.segments)) return std::nullopt;
  const auto jump = FindClockJump(set_up);
  if (!jump.has_value()) return std::nullopt;
  if (set_up.strangers.count(jump->view) > 0) return std::nullopt;
  FreeParameters rotation;
  rotation.rotation = true;
  const BundleResult fit =
      AdjustBundle(set_up.cameras, set_up.segments, rotation,
                   NoChanges(set_up.cameras.size()), set_up.options.bundle);
  SetUp turned = set_up;
  turned.cameras = RefinedCameras(set_up.cameras, fit.changes);
  const auto again = FindClockJump(turned);
  if (!again.has_value() || again->view != jump->view ||
      std::abs(again->missing - jump->missing) > 1) {
    return std::nullopt;
  }
  const auto& frames = set_up.detections.frames;
  const int64_t from = IndexAfter(frames, jump->at_s);
  const auto view = static_cast<int>(jump->view);
  const double before_px = set_up.Fit().MeanPx(view);
  // The number of lost images is the integer near the estimate that fits best.
  // The estimate tends to be too large, because velocities are estimated
  // together with it.
  const int fewer = static_cast<int>(std::floor(jump->jump_s * set_up.rate_hz));
  Answer answer;
  double after_px = (1.0 - FitGain::kLeastShare) * before_px;
  for (const int missing : {fewer, fewer + 1}) {
    if (missing == 0) continue;
    ClockJump whole = *jump;
    whole.missing = missing;
    SetUp moved = set_up;
    moved.detections = WithoutJump(set_up.detections, whole, from);
    moved.Match();
    const double px = moved.Fit().MeanPx(view);
    if (px > after_px) continue;
    after_px = px;
    const auto last = static_cast<int64_t>(frames.size()) - 1;
    answer.findings = {FindingOf(whole, set_up.CameraName(jump->view),
                                 frames[std::min(from, last)].frame,
                                 set_up.number_step, before_px, after_px)};
    answer.detections = std::move(moved.detections);
    answer.segments = std::move(moved.segments);
  }
  if (answer.findings.empty()) return std::nullopt;
  return answer;
}

// The two sides of a break are diagnosed separately: the break is reported if
// there are findings about its view on the worse side, none of them a likely
// clock offset, and none on the other side. The rest of the diagnosis uses the
// better side.
std::optional<Answer> AskForBreak(const SetUp& set_up) {
  if (!set_up.input.match || !set_up.options.looks_for_break) {
    return std::nullopt;
  }
  const auto found =
      FindCameraBreak(set_up.cameras, set_up.ideal, set_up.detections);
  if (!found.has_value()) return std::nullopt;
  const int worse = found->worse_after() ? 1 : 0;
  if (IsLag(set_up, *found, worse)) return std::nullopt;
  Answer answer;
  for (const int side : {worse, 1 - worse}) {
    const Diagnosis part =
        DiagnosePart(set_up, SideOf(set_up.detections, found->from, side));
    for (const Finding& finding : part.findings) {
      if (finding.camera != set_up.CameraName(found->view)) continue;
      const bool sure = finding.confidence > 0.5;
      if (side != worse || (finding.kind == "clock_offset" && sure)) {
        return std::nullopt;
      }
      answer.findings.push_back(OfSide(set_up, *found, finding));
    }
  }
  if (answer.findings.empty()) return std::nullopt;
  answer.detections = SideOf(set_up.detections, found->from, 1 - worse);
  return answer;
}

}  // namespace kinegraph
