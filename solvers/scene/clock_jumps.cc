// Pictures that a view lost or has twice: from there on its clock is off by
// whole frames against the other views.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "solvers/scene/fit_terms.h"
#include "solvers/scene/hypothesis.h"

namespace kinegraph {
namespace {

struct ClockJump {
  int view_idx = 0;
  double at_s = 0.0;  // since the middle of the recording
  // Pictures that are missing before `at_s`; negative: that are too many.
  int missing = 0;
  double jump_s = 0.0;   // as measured
  double sigma_s = 0.0;  // its standard deviation
};

// What a bin says of one view's offset: its information [1/s^2] and the
// gradient there, so that the offset is -gradient / information.
struct ClockBin {
  double time_s = 0.0;
  double information = 0.0;
  double gradient = 0.0;
};
using ClockBins = std::vector<ClockBin>;

// Normal equations of one stretch, with the offset of every view beside its own
// state.
struct SegmentSystem {
  Eigen::Matrix<double, kSegmentSize, kSegmentSize> information;
  SegmentState gradient;
  Eigen::MatrixXd cross;  // between the state and each view's offset
  Eigen::VectorXd offset_information;
  Eigen::VectorXd offset_gradient;
};

SegmentSystem LineariseSegment(const CameraRig& cameras,
                               const SceneSegments& segments,
                               const std::vector<CameraChange>& changes,
                               const SegmentState& prior,
                               const MotionSegment& segment,
                               const SegmentState& state) {
  SegmentSystem system;
  system.information = prior.asDiagonal();
  system.information.topLeftCorner<3, 3>().diagonal().array() +=
      kPositionInformation;
  system.gradient = prior.cwiseProduct(state);
  system.cross = Eigen::MatrixXd::Zero(kSegmentSize, segments.view_count);
  system.offset_information = Eigen::VectorXd::Zero(segments.view_count);
  system.offset_gradient = system.offset_information;
  for (const SegmentTerm& term :
       TermsOf(cameras, changes, segment, state, segments.noise_scale)) {
    const auto v = static_cast<Eigen::Index>(term.view);
    const auto& A = term.by_state;
    const Eigen::Vector2d B = term.by_change.col(kOffsetAt);
    system.information += term.weight * A.transpose() * A;
    system.gradient += term.weight * A.transpose() * term.residual;
    system.cross.col(v) += term.weight * A.transpose() * B;
    system.offset_information[v] += term.weight * B.squaredNorm();
    system.offset_gradient[v] += term.weight * B.dot(term.residual);
  }
  return system;
}

// The bins of all views. A bin is as long as a fortieth of the recording, and
// at least half a second: a walker's step.
std::vector<ClockBins> OffsetBins(const CameraRig& cameras,
                                  const SceneSegments& segments,
                                  const std::vector<CameraChange>& changes,
                                  const SegmentOptions& options) {
  const double length_s = std::max(0.5, segments.span_s / 40.0);
  const double first_s = -0.5 * segments.span_s;
  const auto count =
      static_cast<size_t>(std::ceil(segments.span_s / length_s)) + 1;
  std::vector<ClockBins> bins(cameras.size(), ClockBins(count));
  for (ClockBins& of_view : bins) {
    for (size_t b = 0; b < count; ++b) {
      of_view[b].time_s = first_s + (static_cast<double>(b) + 0.5) * length_s;
    }
  }
  const SegmentState prior = PriorInformation(options);
  for (const MotionSegment& segment : segments.segments) {
    SegmentState state = segment.state;
    if (!SolveSegment(cameras, changes, segment, segments.noise_scale, options,
                      &state)) {
      continue;
    }
    const SegmentSystem system =
        LineariseSegment(cameras, segments, changes, prior, segment, state);
    // The stretch's own state is eliminated.
    const Eigen::MatrixXd solved =
        system.information.ldlt().solve(system.cross);
    const auto b =
        std::min(count - 1, static_cast<size_t>(std::max(
                                0.0, (segment.middle_s - first_s) / length_s)));
    for (size_t v = 0; v < bins.size(); ++v) {
      const auto i = static_cast<Eigen::Index>(v);
      bins[v][b].information +=
          system.offset_information[i] - system.cross.col(i).dot(solved.col(i));
      bins[v][b].gradient +=
          system.offset_gradient[i] - solved.col(i).dot(system.gradient);
    }
  }
  return bins;
}

struct Sums {
  double information = 0.0;
  double gradient = 0.0;
  double offset_s() const { return -gradient / information; }
  // Of 2 * cost, by the offset.
  double gain() const { return gradient * gradient / information; }
};

Sums SumOf(const ClockBins& bins, size_t begin, size_t end) {
  Sums sums;
  for (size_t b = begin; b < end; ++b) {
    sums.information += bins[b].information;
    sums.gradient += bins[b].gradient;
  }
  return sums;
}

// What offset and drift gain.
double GainOfLine(const ClockBins& bins) {
  Eigen::Matrix2d H = Eigen::Matrix2d::Zero();
  Eigen::Vector2d g = Eigen::Vector2d::Zero();
  for (const ClockBin& bin : bins) {
    const Eigen::Vector2d row(1.0, bin.time_s);
    H += bin.information * row * row.transpose();
    g += bin.gradient * row;
  }
  return g.dot(H.ldlt().solve(g));
}

// How much more the bins scatter about two levels than their information says:
// a detector's errors last.
double ScatterOf(const ClockBins& bins, size_t split, const Sums& before,
                 const Sums& after) {
  double squares = 0.0;
  double count = 0.0;
  for (size_t b = 0; b < bins.size(); ++b) {
    if (!(bins[b].information > 0.0)) continue;
    const double level = b < split ? before.offset_s() : after.offset_s();
    const double left = bins[b].gradient + bins[b].information * level;
    squares += left * left / bins[b].information;
    count += 1.0;
  }
  return std::max(1.0, squares / std::max(1.0, count - 3.0));
}

// A split needs this many bins with something in them on either side.
constexpr int kFewestClockBins = 3;

int FilledBins(const ClockBins& bins, size_t begin, size_t end) {
  return static_cast<int>(
      std::count_if(bins.begin() + static_cast<std::ptrdiff_t>(begin),
                    bins.begin() + static_cast<std::ptrdiff_t>(end),
                    [](const ClockBin& bin) { return bin.information > 0.0; }));
}

// A split of one view's bins with the levels on either side.
struct ClockSplit {
  size_t view = 0;
  size_t bin = 0;  // the first one behind it
  double at_s = 0.0;
  double jump_s = 0.0;
  double sigma_s = 0.0;
};

ClockSplit ClockSplitAt(const ClockBins& bins, size_t view, size_t bin,
                        double* gain) {
  const Sums before = SumOf(bins, 0, bin);
  const Sums after = SumOf(bins, bin, bins.size());
  const double scatter = ScatterOf(bins, bin, before, after);
  ClockSplit split;
  split.view = view;
  split.bin = bin;
  split.at_s = 0.5 * (bins[bin - 1].time_s + bins[bin].time_s);
  split.jump_s = after.offset_s() - before.offset_s();
  split.sigma_s =
      std::sqrt(scatter * (1.0 / before.information + 1.0 / after.information));
  *gain = (before.gain() + after.gain() - GainOfLine(bins)) / scatter;
  return split;
}

// The split that explains most, of those that are worth it.
std::optional<ClockSplit> BestClockSplit(const std::vector<ClockBins>& all,
                                         double least_s) {
  // Six standard deviations, for some forty splits of a handful of views; a
  // step that a drift explains nearly as well is none.
  constexpr double kSigmas = 6.0;
  constexpr double kLeastGain = 25.0;
  std::optional<ClockSplit> best;
  double most = kLeastGain;
  for (size_t v = 0; v < all.size(); ++v) {
    for (size_t bin = 1; bin < all[v].size(); ++bin) {
      if (FilledBins(all[v], 0, bin) < kFewestClockBins ||
          FilledBins(all[v], bin, all[v].size()) < kFewestClockBins) {
        continue;
      }
      double gain = 0.0;
      const ClockSplit split = ClockSplitAt(all[v], v, bin, &gain);
      if (!(gain > most) || std::abs(split.jump_s) < least_s ||
          std::abs(split.jump_s) < kSigmas * split.sigma_s) {
        continue;
      }
      most = gain;
      best = split;
    }
  }
  return best;
}

// The stretches with a view's clock moved behind the split.
SceneSegments Moved(const SceneSegments& segments, const ClockSplit& split,
                    double jump_s) {
  SceneSegments moved = segments;
  for (MotionSegment& segment : moved.segments) {
    if (segment.middle_s < split.at_s) continue;
    for (SegmentMeasurement& measurement : segment.measurements) {
      if (measurement.view_idx == static_cast<int>(split.view)) {
        measurement.time_s += jump_s;
      }
    }
  }
  return moved;
}

// The clearest jump of one view's clock, or nullopt. For each view and short
// bins of time the clock's offset is estimated (steps of Gauss and Newton on
// the stretches, their states eliminated, the other views taken as right); a
// jump is two levels that explain the bins better than offset and drift do,
// nearly whole frames apart.
std::optional<ClockJump> FindClockJump(const CameraRig& cameras,
                                       const SceneSegments& segments,
                                       const std::vector<CameraChange>& changes,
                                       const SegmentOptions& options,
                                       double frame_s) {
  const auto split = BestClockSplit(
      OffsetBins(cameras, segments, changes, options), 0.3 * frame_s);
  if (!split.has_value()) return std::nullopt;
  // One step falls short: the states and the loss take their share.
  double jump_s = split->jump_s;
  constexpr int kMostSteps = 6;
  for (int step = 0; step < kMostSteps; ++step) {
    const std::vector<ClockBins> left =
        OffsetBins(cameras, Moved(segments, *split, jump_s), changes, options);
    double gain = 0.0;
    const double more_s =
        ClockSplitAt(left[split->view], split->view, split->bin, &gain).jump_s;
    jump_s += more_s;
    if (std::abs(more_s) < 0.05 * frame_s) break;
  }
  // Pictures are lost whole.
  constexpr double kFromWhole = 0.35;
  const double frames = jump_s / frame_s;
  if (std::round(frames) == 0.0 ||
      std::abs(frames - std::round(frames)) > kFromWhole) {
    return std::nullopt;
  }
  return ClockJump{static_cast<int>(split->view), split->at_s,
                   static_cast<int>(std::lround(frames)), jump_s,
                   split->sigma_s};
}

// The detections with the jump taken back: the view's pictures from index
// `from` on move by what is missing.
DetectionSequence WithoutJump(const DetectionSequence& detections,
                              const ClockJump& jump, int64_t from) {
  const auto jumping = static_cast<size_t>(jump.view_idx);
  return FramesMoved(detections, [&](size_t view, int64_t k) -> int64_t {
    if (view != jumping || k < std::min(from, from + jump.missing)) return k;
    return k - jump.missing >= from ? k - jump.missing : -1;
  });
}

// Index of the first frame after a time since the middle of the recording.
int64_t IndexAfter(const std::vector<DetectionFrame>& frames, double at_s) {
  const TimeNs middle =
      frames.front().time + (frames.back().time - frames.front().time) / 2;
  const auto at = std::lower_bound(
      frames.begin(), frames.end(), middle + FromSeconds(at_s),
      [](const DetectionFrame& f, TimeNs time) { return f.time < time; });
  return at - frames.begin();
}

Finding FindingOf(const ClockJump& jump, const std::string& camera,
                  int64_t frame, double before_px, double after_px) {
  const double count = std::abs(jump.missing);
  const bool lost = jump.missing > 0;
  const auto number = static_cast<double>(frame);
  return {"frames",
          camera,
          0.9,
          before_px,
          after_px,
          lost ? Format("give its files from about %.0f on numbers that are "
                        "%.0f higher",
                        number, count)
               : Format("take %.0f pictures out before about frame %.0f", count,
                        number),
          Format(lost ? "%.0f pictures are missing before about frame %.0f"
                      : "%.0f pictures are too many before about frame %.0f",
                 count, number) +
              Format(": its clock jumps by %+.1f +- %.1f ms", 1e3 * jump.jump_s,
                     1e3 * jump.sigma_s)};
}

}  // namespace

// A jump counts where the matches then fit better.
std::optional<Answer> AskForJump(const SetUp& set_up) {
  if (!MoveEnough(set_up.segments)) return std::nullopt;
  const std::vector<CameraChange> none(set_up.cameras.size(),
                                       CameraChange::Zero());
  const auto jump = FindClockJump(
      set_up.cameras, set_up.segments, none, set_up.options.bundle.segments,
      1.0 / std::max(1.0, set_up.input.frame_rate_hz));
  if (!jump.has_value()) return std::nullopt;
  const auto view = static_cast<size_t>(jump->view_idx);
  if (set_up.strangers.count(view) > 0) return std::nullopt;
  const auto& frames = set_up.detections.frames;
  const int64_t from = IndexAfter(frames, jump->at_s);
  SetUp moved = set_up;
  moved.detections = WithoutJump(set_up.detections, *jump, from);
  moved.Match();
  const double before_px = set_up.Fit().MeanPx(jump->view_idx);
  const double after_px = moved.Fit().MeanPx(jump->view_idx);
  if (before_px - after_px < FitGain::kLeastShare * before_px) {
    return std::nullopt;
  }
  const auto last = static_cast<int64_t>(frames.size()) - 1;
  Answer answer;
  answer.findings.push_back(
      FindingOf(*jump, set_up.CameraName(view),
                frames[static_cast<size_t>(std::min(from, last))].frame,
                before_px, after_px));
  answer.detections = std::move(moved.detections);
  answer.segments = std::move(moved.segments);
  return answer;
}

}  // namespace kinegraph
