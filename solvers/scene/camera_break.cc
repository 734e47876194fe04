// A camera that was moved in the middle of a recording: from some frame on its
// view no longer agrees with the others as it did.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

#include "solvers/scene/clock_search.h"
#include "solvers/scene/hypothesis.h"
#include "solvers/scene/plausible.h"

namespace kinegraph {
namespace {

struct CameraBreak {
  size_t view = 0;
  size_t from = 0;  // index of the first frame behind it
  // Agreement with the other views (PairAgreement) on either side, less that of
  // the other views among themselves.
  double before = 0.0;
  double after = 0.0;

  bool worse_after() const { return after < before; }
};

// A view's agreement with the others and that of the others among themselves,
// over some frames.
struct Sides {
  PairAgreement own;
  PairAgreement others;

  void Add(const Sides& more) {
    own.Add(more.own);
    others.Add(more.others);
  }
  bool known() const { return own.possible > 0.0 && others.possible > 0.0; }
  double level() const { return own.score() - others.score(); }
};

// [view][frame looked at]
std::vector<std::vector<Sides>> LookAtFrames(
    const CameraRig& cameras, const std::vector<ViewPeople>& ideal,
    const std::vector<int>& frames) {
  const size_t views = cameras.size();
  std::vector<std::vector<Sides>> all(views, std::vector<Sides>(frames.size()));
  for (size_t i = 0; i < frames.size(); ++i) {
    for (size_t a = 0; a < views; ++a) {
      for (size_t b = a + 1; b < views; ++b) {
        const PairAgreement pair = AgreementOf(cameras[a], ideal[a], cameras[b],
                                               ideal[b], {frames[i]});
        for (size_t v = 0; v < views; ++v) {
          (v == a || v == b ? all[v][i].own : all[v][i].others).Add(pair);
        }
      }
    }
  }
  return all;
}

// A view's levels by bins of neighbouring frames, each with the first frame
// that it looks at.
struct Bin {
  size_t begin = 0;
  double level = 0.0;
};

std::vector<Bin> BinsOf(const std::vector<Sides>& frames, size_t count) {
  std::vector<Bin> bins;
  for (size_t b = 0; b < count; ++b) {
    const size_t begin = frames.size() * b / count;
    const size_t end = frames.size() * (b + 1) / count;
    Sides sum;
    for (size_t i = begin; i < end; ++i) sum.Add(frames[i]);
    if (sum.known()) bins.push_back({begin, sum.level()});
  }
  return bins;
}

double MeanLevel(const std::vector<Bin>& bins, size_t begin, size_t end) {
  double sum = 0.0;
  for (size_t b = begin; b < end; ++b) sum += bins[b].level;
  return sum / static_cast<double>(end - begin);
}

struct Split {
  size_t bin = 0;  // the first one behind it
  double before = 0.0;
  double after = 0.0;
  double sigmas = 0.0;  // the step over its standard deviation

  double step() const { return std::abs(after - before); }
};

Split SplitAt(const std::vector<Bin>& bins, size_t at) {
  Split split{at, MeanLevel(bins, 0, at), MeanLevel(bins, at, bins.size()),
              0.0};
  double squares = 0.0;
  for (size_t b = 0; b < bins.size(); ++b) {
    squares +=
        std::pow(bins[b].level - (b < at ? split.before : split.after), 2);
  }
  const auto count = static_cast<double>(bins.size());
  const auto first = static_cast<double>(at);
  const double variance = squares / (count - 2.0);
  split.sigmas =
      split.step() /
      std::sqrt(variance * (1.0 / first + 1.0 / (count - first)) + 1e-12);
  return split;
}

// Bins of either side.
constexpr size_t kFewestBins = 3;

// The split of a view's bins that is the surest.
std::optional<Split> BestSplit(const std::vector<Bin>& bins) {
  std::optional<Split> best;
  for (size_t at = kFewestBins; at + kFewestBins <= bins.size(); ++at) {
    const Split split = SplitAt(bins, at);
    if (!best.has_value() || split.sigmas > best->sigmas) best = split;
  }
  return best;
}

// The frame about a split of the bins where the two sides differ most.
size_t FrameOf(const std::vector<Sides>& frames, const std::vector<Bin>& bins,
               const Split& split) {
  const size_t begin = bins[split.bin - 1].begin;
  const size_t end =
      split.bin + 1 < bins.size() ? bins[split.bin + 1].begin : frames.size();
  const double middle = 0.5 * (split.before + split.after);
  const double sign = split.after < split.before ? 1.0 : -1.0;
  // Frames before it should lie on the one side of the middle, those behind it
  // on the other.
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

// The clearest break, or nullopt: two levels of one view's agreement, frame by
// frame. With fewer than three views nobody can say whose it is. A lost picture
// looks alike.
std::optional<CameraBreak> FindCameraBreak(
    const CameraRig& cameras, const std::vector<ViewPeople>& ideal,
    const DetectionSequence& detections) {
  // People who come, go and hide each other move the level, too.
  constexpr double kLeastStep = 0.04;
  constexpr double kSigmas = 5.0;
  constexpr int kMostFrames = 400;
  constexpr double kBinS = 0.5;  // a walker's step
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
    const std::vector<Bin> bins = BinsOf(all[v], count);
    const auto split = BestSplit(bins);
    if (!split.has_value() || split->sigmas < kSigmas ||
        split->step() < kLeastStep ||
        (found.has_value() &&
         split->step() <= std::abs(found->after - found->before))) {
      continue;
    }
    const size_t at =
        std::min(FrameOf(all[v], bins, *split), frames.size() - 1);
    found = CameraBreak{v, static_cast<size_t>(frames[at]), split->before,
                        split->after};
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

// Whether a lag makes the worse side as good as the other one: pictures were
// lost, which are looked for later.
bool IsLag(const SetUp& set_up, const CameraBreak& found, int worse) {
  constexpr double kNearly = 0.05;  // of agreement
  const auto ideal_of = [&](int side) {
    return set_up.Ideal(PeopleOfViews(
        SideOf(set_up.detections, found.from, side), kMinJointConfidence));
  };
  const ClockSearch lags =
      SearchClocks(set_up.cameras, ideal_of(worse), set_up.LongestLag());
  if (!lags.found()) return false;
  const std::vector<ViewPeople> better = ideal_of(1 - worse);
  const double score =
      AgreementOfAll(set_up.cameras, better,
                     FramesToLookAt(better, set_up.options.frames_to_look_at))
          .score();
  return lags.all.after.score() > score - kNearly;
}

Diagnosis DiagnosePart(const SetUp& set_up, DetectionSequence part) {
  DoctorInput input = set_up.input;
  for (size_t v = 0; v < set_up.cameras.size(); ++v) {
    CameraParameters parameters = set_up.cameras[v].parameters();
    parameters.name = set_up.CameraName(v);
    input.cameras[v] = Camera(std::move(parameters));
  }
  input.detections = std::move(part);
  DoctorOptions options = set_up.options;
  options.looks_for_break = false;
  options.longest_lag_s = 0.0;
  return Diagnose(input, options);
}

// What is said of one side, as a finding of the whole.
Finding OfSide(const SetUp& set_up, const CameraBreak& found, Finding finding) {
  const auto& frames = set_up.detections.frames;
  const auto first = static_cast<double>(frames.front().frame);
  const auto from = static_cast<double>(frames[found.from].frame);
  const auto end = static_cast<double>(frames.back().frame + 1);
  const bool after = found.worse_after();
  const std::string side =
      Format("--frames=%.0f:%.0f", after ? from : first, after ? end : from);
  const std::string other =
      Format("--frames=%.0f:%.0f", after ? first : from, after ? from : end);
  finding.fix =
      finding.kind == "never_matched"
          ? side + " " + finding.fix
          : "kinegraph doctor INPUTS " + side + " --out=doctor_of_these";
  finding.evidence =
      Format(after ? "from about frame %.0f on: " : "before about frame %.0f: ",
             from) +
      finding.evidence +
      "; it was moved in the middle of the recording: track the frames before "
      "and after apart, the others with " +
      other + ", these with the cameras.json that the fix writes";
  return finding;
}

}  // namespace

// The two sides of a break are diagnosed apart: what is said of the view on the
// worse one and not on the other is the break. The rest of the diagnosis is of
// the better side.
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
