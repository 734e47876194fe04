// The list of hypotheses, and those that need little code.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "core/base/text.h"
#include "core/evaluation/statistics.h"
#include "core/skeleton/body_joints.h"
#include "core/tracking/track.h"
#include "solvers/scene/clock_search.h"
#include "solvers/scene/hypothesis.h"
#include "solvers/scene/plausible.h"

namespace kinegraph {
namespace {

// ---- Files ----

// Frames too far apart to follow people.
std::optional<Answer> AskForGaps(const SetUp& set_up) {
  if (set_up.input.independent_frames) return std::nullopt;
  const std::vector<DetectionFrame>& frames = set_up.input.detections.frames;
  std::vector<double> gaps_s;
  for (size_t k = 1; k < frames.size(); ++k) {
    gaps_s.push_back(ToSeconds(frames[k].time - frames[k - 1].time));
  }
  if (gaps_s.empty()) return std::nullopt;
  const double gap_s = Quantile(std::move(gaps_s), 0.5);
  if (gap_s <= kHole) return std::nullopt;
  return AnswerWith(
      {"frame_rate", "", gap_s > kLongestGapS ? 0.95 : 0.5, 0.0, 0.0,
       "--set=input.independent_frames=true",
       fmt::format("frames are {:.3g} s apart: people cannot be followed over "
                   "such gaps, unless input.frame_rate is wrong",
                   gap_s)});
}

// Fraction of the joints that differ between the two images; nullopt if these
// show nobody or different numbers of people.
std::optional<double> ChangedShare(const ViewDetections& a,
                                   const ViewDetections& b) {
  if (a.detections.empty() || a.detections.size() != b.detections.size()) {
    return std::nullopt;
  }
  double changed = 0.0;
  double all = 0.0;
  for (size_t d = 0; d < a.detections.size(); ++d) {
    const auto& one = a.detections[d].joints;
    const auto& other = b.detections[d].joints;
    for (size_t j = 0; j < one.size(); ++j) {
      if (!one[j].found && !other[j].found) continue;
      all += 1.0;
      changed +=
          one[j].found != other[j].found || one[j].px != other[j].px ? 1 : 0;
    }
  }
  if (all == 0.0) return std::nullopt;
  return changed / all;
}

// Duplicated images have detections that are identical to the last digit. With
// integer pixels and people standing still this also happens by chance, so at
// least 80 % of the joints must have differed in the last pair that differed.
std::optional<Finding> RepeatsOf(const SetUp& set_up, size_t view) {
  const std::vector<DetectionFrame>& frames = set_up.input.detections.frames;
  constexpr double kMoving = 0.8;
  constexpr double kLeastShare = 0.01;
  int64_t repeats = 0;
  int64_t pairs = 0;
  int64_t first = -1;
  double last_change = 0.0;
  for (size_t k = 1; k < frames.size(); ++k) {
    const auto change =
        ChangedShare(frames[k - 1].views[view], frames[k].views[view]);
    if (!change.has_value()) continue;
    ++pairs;
    if (*change > 0.0) {
      last_change = *change;
    } else if (last_change >= kMoving) {
      if (first < 0) first = frames[k].frame;
      ++repeats;
    }
  }
  if (repeats == 0 ||
      static_cast<double>(repeats) < kLeastShare * static_cast<double>(pairs)) {
    return std::nullopt;
  }
  return Finding{
      "frames",
      set_up.CameraName(view),
      0.9,
      0.0,
      0.0,
      "remove the repeated images, or set the view's own rate "
      "(input.view_frame_rate)",
      fmt::format("{} of {} {} the previous one, the first in frame {}",
                  repeats, Counted(pairs, "image", "images"),
                  repeats == 1 ? "repeats" : "repeat", first)};
}

std::optional<Answer> AskForRepeats(const SetUp& set_up) {
  Answer answer;
  for (size_t v = 0; v < set_up.cameras.size(); ++v) {
    if (auto repeats = RepeatsOf(set_up, v)) {
      answer.findings.push_back(*std::move(repeats));
    }
  }
  return answer;
}

// The range of frames in which a view has detections.
struct ShownFrames {
  int64_t first = 0;
  int64_t last = -1;
  bool any() const { return first <= last; }
  bool Meets(const ShownFrames& other) const {
    return any() && other.any() && first <= other.last && other.first <= last;
  }
};

std::vector<ShownFrames> FramesShown(const DetectionSequence& detections) {
  std::vector<ShownFrames> shown(detections.header.view_names.size());
  for (const DetectionFrame& frame : detections.frames) {
    for (size_t v = 0; v < shown.size(); ++v) {
      if (frame.views[v].detections.empty()) continue;
      if (!shown[v].any()) shown[v].first = frame.frame;
      shown[v].last = frame.frame;
    }
  }
  return shown;
}

// What to subtract from each view's frame numbers so that all views have common
// frames: zero, except for views that share no frame with the reference, the
// view that overlaps most others (the first of equals). Such views then begin
// with the reference.
std::vector<int64_t> FrameOffsets(const std::vector<ShownFrames>& shown) {
  const ShownFrames* reference = nullptr;
  std::ptrdiff_t most = 0;
  for (const ShownFrames& one : shown) {
    const auto count =
        std::count_if(shown.begin(), shown.end(),
                      [&](const ShownFrames& o) { return one.Meets(o); });
    if (count > most) reference = &one;
    most = std::max(most, count);
  }
  std::vector<int64_t> offsets(shown.size(), 0);
  if (reference == nullptr) return offsets;  // no detections in any view
  for (size_t v = 0; v < shown.size(); ++v) {
    const ShownFrames& one = shown[v];
    const bool stays = !one.any() || one.Meets(*reference);
    if (!stays) offsets[v] = one.first - reference->first;
  }
  return offsets;
}

DetectionSequence WithFrameOffsets(const DetectionSequence& detections,
                                   const std::vector<int64_t>& offsets) {
  DetectionSequence moved =
      FramesMoved(detections, [&](size_t v, int64_t k) -> int64_t {
        if (offsets[v] == 0) return k;
        return IndexOfFrame(detections,
                            detections.frames[k].frame + offsets[v]);
      });
  // Removes the empty frames before and after the common ones. Those between
  // remain, so that frames stay evenly spaced (SetUp::detections).
  auto& frames = moved.frames;
  frames.erase(frames.begin(),
               std::find_if(frames.begin(), frames.end(), HasDetections));
  while (!frames.empty() && !HasDetections(frames.back())) frames.pop_back();
  return moved;
}

std::optional<Answer> AskForFrameRanges(const SetUp& set_up) {
  const std::vector<ShownFrames> shown = FramesShown(set_up.detections);
  const std::vector<int64_t> offsets = FrameOffsets(shown);
  if (std::count(offsets.begin(), offsets.end(), 0) ==
      static_cast<std::ptrdiff_t>(offsets.size())) {
    return std::nullopt;
  }
  const auto range = [&](size_t v) {
    return " " + set_up.ViewName(v) + " " + std::to_string(shown[v].first) +
           ".." + std::to_string(shown[v].last);
  };
  std::string others;
  std::string keys;
  for (size_t v = 0; v < shown.size(); ++v) {
    if (offsets[v] == 0) {
      others += range(v);
      continue;
    }
    keys += (keys.empty() ? "" : ";") +
            ("input.view_frame_offset." + set_up.ViewName(v)) + "=" +
            std::to_string(offsets[v]);
  }
  Answer answer;
  for (size_t v = 0; v < shown.size(); ++v) {
    if (offsets[v] == 0) continue;
    answer.findings.push_back({"frame_range", set_up.CameraName(v), 0.95, 0.0,
                               0.0, "'--set=" + keys + "'",
                               "it shares no frame with the others:" +
                                   range(v) + " against" + others +
                                   "; if all views begin together, its frame "
                                   "numbers are too high by " +
                                   std::to_string(offsets[v])});
  }
  answer.detections = WithFrameOffsets(set_up.detections, offsets);
  return answer;
}

// ---- Views with one calibration ----

// Two views with the same calibration: of the two, the one that agrees less
// with the remaining views was given the calibration of the other one. That
// view is excluded from the hypotheses that follow, which would otherwise
// compensate with a clock or a rotation.
std::optional<Answer> AskForTwins(const SetUp& set_up) {
  const auto alike = [&](size_t a, size_t b) {
    const Camera& one = set_up.cameras[a];
    const Camera& other = set_up.cameras[b];
    // Cameras are never mounted within a millimetre with the same orientation.
    return set_up.strangers.count(a) + set_up.strangers.count(b) == 0 &&
           (one.centre() - other.centre()).norm() <= 1e-3 &&
           (one.R() - other.R()).cwiseAbs().maxCoeff() <= 1e-4;
  };
  for (size_t a = 0; a < set_up.cameras.size(); ++a) {
    for (size_t b = a + 1; b < set_up.cameras.size(); ++b) {
      if (!alike(a, b)) continue;
      const double score_a = set_up.WithOthers(a).score();
      const double score_b = set_up.WithOthers(b).score();
      const size_t wrong = score_a < score_b ? a : b;
      Answer answer =
          AnswerWith({"never_matched", set_up.CameraName(wrong), 0.9, 0.0, 0.0,
                      "--without_cameras=" + set_up.CameraName(wrong),
                      "its calibration equals that of " +
                          set_up.CameraName(wrong == a ? b : a) +
                          fmt::format(", and its agreement with the other "
                                      "views is {:.2f} instead of {:.2f}",
                                      std::min(score_a, score_b),
                                      std::max(score_a, score_b))});
      answer.strangers = {wrong};
      return answer;
    }
  }
  return std::nullopt;
}

// ---- Clocks ----

// The median lag, which has the least sum of distances to the others; if it is
// not unique, the first.
int UsualLag(const std::vector<int>& lags) {
  const auto distance = [&](int from) {
    int sum = 0;
    for (const int lag : lags) sum += std::abs(lag - from);
    return sum;
  };
  return *std::min_element(lags.begin(), lags.end(), [&](int a, int b) {
    return distance(a) < distance(b);
  });
}

std::optional<Answer> AskForLags(const SetUp& set_up) {
  const ClockSearch clocks =
      SearchClocks(set_up.cameras, set_up.ideal, set_up.LongestLag());
  if (!clocks.found()) return std::nullopt;
  // A shifted image makes a person walking in one direction appear to lag.
  if (AMovedImageHelps(set_up)) return std::nullopt;
  const double sureness =
      AgreementGain::Sureness(clocks.moved.gain(), clocks.all.after.score());
  Answer answer;
  std::vector<int> lags = clocks.lag_frames;
  const int usual = UsualLag(lags);
  // Beside larger lags, a lag of one frame may be an error of the search. It is
  // left to the examination of the matches, which measures clocks more
  // precisely, unless a frame is longer than the largest clock error that the
  // examination can measure (kFarthestClockS).
  const bool by_more = std::any_of(lags.begin(), lags.end(), [&](int lag) {
    return std::abs(lag - usual) > 1;
  });
  const int least = by_more && set_up.rate_hz * kFarthestClockS > 1.0 ? 2 : 1;
  for (size_t v = 0; v < set_up.cameras.size(); ++v) {
    const int lag = lags[v] - usual;
    if (std::abs(lag) < least) {
      lags[v] = usual;
      continue;
    }
    answer.findings.push_back(
        {"clock_offset", set_up.CameraName(v), sureness,
         clocks.all.before.mean_px(), clocks.all.after.mean_px(), kRefineClocks,
         fmt::format("frame k of most views agrees best with its frame k{:+}: "
                     "its images were captured {:+.3f} s from their timestamps",
                     lag * set_up.number_step, -lag / set_up.rate_hz)});
  }
  answer.score = clocks.all.after.score();
  answer.detections = Realigned(set_up.detections, lags);
  return answer;
}

// ---- The world ----

// The agreement of each view's people with the people of the other views at
// other times, i.e. the agreement by chance in this recording.
PairAgreement AgreementByChance(const SetUp& set_up) {
  constexpr int kLags = 8;
  const auto count = static_cast<int>(set_up.ideal[0].frames.size());
  std::vector<int> lags;
  for (int i = 1; i <= kLags / 2; ++i) {
    const int lag = std::max(1, i * count / (kLags + 2));
    lags.push_back(lag);
    lags.push_back(-lag);
  }
  PairAgreement all;
  for (const auto& [a, b] : ComparedPairs(set_up.cameras.size())) {
    for (const PairAgreement& at_lag :
         AgreementsOf(set_up.cameras[a], set_up.ideal[a], set_up.cameras[b],
                      set_up.ideal[b], set_up.frames, lags)) {
      all.Add(at_lag);
    }
  }
  return all;
}

// Whether people agree at the same time by more than chance explains. With
// calibrations of other recordings, agreement at the same time is at most 1.5
// times that at other times and exceeds it by at most 0.04; with the right
// calibration it is at least 1.7 times that at other times, unless people stand
// still or hardly anybody is matched.
bool AgreesByMoreThanChance(const SetUp& set_up) {
  constexpr double kTimes = 1.7;
  constexpr double kMore = 0.04;
  const PairAgreement chance = AgreementByChance(set_up);
  // If people are present only briefly, the agreement by chance is unknown.
  if (chance.possible < set_up.agreement.possible) return false;
  return set_up.agreement.score() >=
         std::max(kTimes * chance.score(), chance.score() + kMore);
}

// No reinterpretation of files, cameras, images or clocks makes the views
// agree.
std::optional<Answer> AskForAnotherRoom(const SetUp& set_up) {
  // Views of recordings without faults usually agree to 0.5 or more; unrelated
  // people of two views to about 0.1.
  constexpr double kUnrelated = 0.2;
  const PairAgreement& as_read = set_up.agreement;
  if (set_up.readings_changed > 0 || as_read.score() > kUnrelated ||
      AgreesByMoreThanChance(set_up)) {
    return std::nullopt;
  }
  return AnswerWith(
      {"never_matched", "", 0.8, as_read.mean_px(), as_read.mean_px(),
       kCalibrateAnew,
       fmt::format(
           "the agreement of the views is only {:.2f} (1 is perfect), and "
           "neither another reading "
           "of the calibration nor a lag improves this: the calibration may "
           "belong to another set-up, or to other images than the detections",
           as_read.score())});
}

std::string UnitFix(const DoctorInput& input, double units_per_metre) {
  if (!input.unit_can_be_set) return kUseCorrected;
  for (const auto& [units, name] :
       {std::pair{1.0, "m"}, {100.0, "cm"}, {1000.0, "mm"}}) {
    if (std::abs(units_per_metre / units - 1.0) < 1e-9) {
      return std::string("--set=cameras.unit=") + name;
    }
  }
  return kUseCorrected;
}

std::optional<Answer> AskForUnit(const SetUp& set_up) {
  const Stature stature = StatureOf(set_up.cameras, set_up.ideal, set_up.frames,
                                    set_up.detections.header.skeleton);
  Answer answer;
  if (stature.count < kEnoughStatures) {
    answer.notes.emplace_back("too few whole bodies to determine the unit");
    return answer;
  }
  answer.notes.push_back(
      fmt::format("people are {:.3g} m tall (median of {} bodies)",
                  stature.median_m, stature.count));
  answer.stature_m = stature.median_m;
  if (IsStature(stature.median_m)) return answer;
  const double px = set_up.agreement.mean_px();
  const std::string found =
      fmt::format("people would be {:.3g} m tall", stature.median_m);
  for (const double factor : {0.001, 0.01, 0.1, 10.0, 100.0, 1000.0}) {
    const double height_m = stature.median_m * factor;
    if (!IsStature(height_m)) continue;
    answer.findings.push_back(
        {"unit", "", 0.95, px, px,
         UnitFix(set_up.input, set_up.input.units_per_metre / factor),
         found +
             fmt::format(
                 "; with lengths multiplied by {:.4g} they are {:.2f} m tall",
                 factor, height_m)});
    answer.cameras = Rescaled(set_up.cameras, factor);
    return answer;
  }
  // No unit explains the height; perhaps the square size of a calibration board
  // was wrong.
  answer.findings.push_back(
      {"unit", "", 0.5, px, px,
       "measure a length in the room and scale the calibration",
       found + ", and no unit makes them 0.5 to 2.3 m tall"});
  return answer;
}

// ---- With the tracker's matches ----

// Views with hardly any matches. The few matches are wrong, so the views are
// excluded from the hypotheses that follow.
std::optional<Answer> AskForStrangers(const SetUp& set_up) {
  Answer answer;
  for (size_t v = 0; v < set_up.cameras.size(); ++v) {
    const int64_t all = set_up.segments.matchable[v];
    const int64_t matched = set_up.segments.matched[v];
    if (!HardlyAny(matched, all)) continue;
    answer.strangers.push_back(v);
    answer.findings.push_back(
        {"never_matched", set_up.CameraName(v), 0.9, 0.0, 0.0,
         "--without_cameras=" + set_up.CameraName(v),
         fmt::format("its detections are matched in {} of {} cases in which "
                     "two other views match a person",
                     matched, all)});
  }
  return answer;
}

// People faster than any human: the frame rate is lower than specified.
std::optional<Answer> AskForSpeed(const SetUp& set_up) {
  // With a specified rate that is much too high, the recording is so short that
  // it has few segments.
  constexpr size_t kEnough = 20;
  const Skeleton& skeleton = set_up.detections.header.skeleton;
  if (!IsHuman(skeleton)) return std::nullopt;
  std::vector<double> speeds_mps;
  for (const MotionSegment& segment : set_up.segments.segments) {
    const std::string& name = skeleton.joints()[segment.joint];
    if (name != "l_hip" && name != "r_hip") continue;
    speeds_mps.push_back(segment.state.segment<3>(3).norm());
  }
  if (speeds_mps.size() < kEnough) return std::nullopt;
  const double speed_mps = Quantile(std::move(speeds_mps), 0.95);
  if (speed_mps <= kMaxBodySpeed) return std::nullopt;
  return AnswerWith(
      {"frame_rate", "", 0.8, 0.0, 0.0,
       "set input.frame_rate to the true frame rate",
       fmt::format("people move at {:.1f} m/s if the frame rate is {:.4g} Hz",
                   speed_mps, set_up.detections.header.frame_rate_hz)});
}

std::optional<Answer> AskForLens(const SetUp& set_up) {
  const auto has_lens = [](const Camera& one) { return one.lens() != nullptr; };
  if (std::none_of(set_up.cameras.begin(), set_up.cameras.end(), has_lens)) {
    return std::nullopt;
  }
  CameraRig bare = Edited(
      set_up.cameras, [](CameraParameters* camera) { camera->lens = nullptr; });
  const FitGain gain = CompareFits(
      set_up.Fit(), MeasureFit(bare, set_up.segments, NoChanges(bare.size()),
                               set_up.options.bundle.segments));
  // Small distortion fits equally well with and without the lens.
  if (!gain.is_enough()) return std::nullopt;
  Answer answer = AnswerWith(
      {"lens", "", 0.9, gain.before_px, gain.after_px,
       "--set=cameras.ignore_distortion=true",
       "the detections fit better without lens distortion: their images were "
       "already undistorted, or the coefficients belong to another lens"});
  answer.cameras = std::move(bare);
  return answer;
}

}  // namespace

const std::vector<Hypothesis>& Hypotheses() {
  constexpr int kMostTwins = 8;
  constexpr int kMostJumps = 5;
  constexpr int kMostReadings = 3;
  static const std::vector<Hypothesis> kAll = {
      {"gaps between frames", Stage::kFiles, AskForGaps},
      {"repeated pictures", Stage::kFiles, AskForRepeats},
      {"frame ranges", Stage::kFiles, AskForFrameRanges},
      {"one calibration twice", Stage::kTwins, AskForTwins, kMostTwins},
      {"image scaled or cropped", Stage::kReadings, AskForOtherImage,
       kMostReadings},
      {"another rate", Stage::kReadings, AskForOtherRate, kMostReadings},
      {"another reading", Stage::kReadings, AskForOtherReading, kMostReadings},
      {"left and right", Stage::kReadings, AskForSides, kMostReadings},
      {"clocks, whole frames", Stage::kReadings, AskForLags},
      {"another room", Stage::kWorld, AskForAnotherRoom},
      {"unit", Stage::kWorld, AskForUnit},
      {"a camera that was moved", Stage::kWorld, AskForBreak},
      {"views that are hardly ever matched", Stage::kStrangers,
       AskForStrangers},
      {"lost pictures", Stage::kJumps, AskForJump, kMostJumps},
      {"people too fast", Stage::kMatches, AskForSpeed},
      {"lens", Stage::kMatches, AskForLens},
      {"residuals", Stage::kMatches, AskResiduals},
  };
  return kAll;
}

}  // namespace kinegraph
