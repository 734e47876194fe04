#include "core/evaluation/frame_pairing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <tuple>
#include <utility>

#include "core/base/error.h"
#include "core/base/median.h"
#include "core/base/time.h"

namespace kinegraph {
namespace {

// Greatest relative difference of rates that are treated as equal: twice that
// of 29.97 (30000/1001) and 30 Hz.
constexpr double kSameRate = 0.002;
// A stated rate contradicts the times if it differs from their rate by more
// than this share. The closest common rates that kSameRate does not treat as
// equal, 24 and 25 Hz, differ by twice as much.
constexpr double kSameClock = 0.02;
// Frames of recordings with different rates show the same instant up to this
// difference: times in whole milliseconds have errors of up to half a
// millisecond on each side (and doubles are not exact). At 1.5 m/s, a walk, it
// amounts to 1.5 mm.
constexpr TimeNs kSameInstant = 1'001'000;
// Ratio of the numbers of frames that cameras of 25 and of 30 Hz take in the
// same time.
constexpr double kLeastRatio = 1.2;
// A gap above this share of a frame exceeds rounding of times and rates (as in
// the TRC reader).
constexpr double kRoundingFrames = 0.25;

// The times of a recording's frames.
struct Clock {
  std::vector<TimeNs> times;  // ascending; empty: unknown
  double rate_hz = 0.0;       // 0: unknown

  bool is_known() const { return !times.empty() && rate_hz > 0.0; }
  size_t NearestTo(TimeNs time) const {
    const auto after = std::lower_bound(times.begin(), times.end(), time);
    const auto at = static_cast<size_t>(after - times.begin());
    if (at == 0) return 0;
    if (at == times.size()) return at - 1;
    return time - times[at - 1] <= times[at] - time ? at - 1 : at;
  }
  std::string Text(const std::string& name) const {
    return fmt::format("{} {:.5g} Hz ({:.6g} to {:.6g} s)", name, rate_hz,
                       ToSeconds(times.front()), ToSeconds(times.back()));
  }
};

Clock ClockOf(const TrackSequence& recording, const std::string& name,
              std::vector<std::string>* notes) {
  const std::vector<TrackFrame>& frames = recording.frames;
  const double stated_hz = recording.header.frame_rate_hz;
  Clock clock;
  clock.rate_hz = stated_hz;
  if (frames.empty()) return clock;
  std::vector<double> rates_hz;  // from single steps
  for (size_t f = 1; f < frames.size(); ++f) {
    const TimeNs step = frames[f].time - frames[f - 1].time;
    if (step <= 0) {
      if (frames.front().time != frames.back().time) {
        notes->push_back("the times of " + name +
                         " do not always increase: frames are paired by "
                         "number");
      }
      return clock;
    }
    const int64_t count = frames[f].frame - frames[f - 1].frame;
    rates_hz.push_back(static_cast<double>(count) / ToSeconds(step));
  }
  if (!rates_hz.empty()) {
    const double mean_hz =
        static_cast<double>(frames.back().frame - frames.front().frame) /
        ToSeconds(frames.back().time - frames.front().time);
    // The mean is affected by pauses, the median by rounding.
    const auto is_stated = [&](double rate_hz) {
      return std::abs(rate_hz - stated_hz) <= kSameClock * rate_hz;
    };
    if (!is_stated(mean_hz) && !is_stated(Median(std::move(rates_hz)))) {
      clock.rate_hz = mean_hz;
      if (stated_hz > 0.0) {
        notes->push_back(fmt::format(
            "{} states {:g} Hz, but its times are those of {:.4g} Hz", name,
            stated_hz, mean_hz));
      }
    }
  }
  if (!(clock.rate_hz > 0.0)) return clock;
  // In a part cut from a recording, frames may keep their numbers while times
  // begin at zero. The numbers then give its position in the recording.
  const auto number = static_cast<double>(frames.front().frame);
  const double elapsed = ToSeconds(frames.front().time) * clock.rate_hz;
  const bool begins_anew = elapsed >= 0.0 && elapsed < 1.5 && number >= 2.0 &&
                           number > elapsed + 1.0;
  const TimeNs begin =
      begins_anew ? FromSeconds((number - elapsed) / clock.rate_hz) : 0;
  for (const TrackFrame& frame : frames) {
    clock.times.push_back(frame.time + begin);
  }
  return clock;
}

// The position of an instant among the frames of a recording.
struct Place {
  int64_t frame = 0;  // the nearest number, whether or not the frame exists
  TimeNs off = 0;     // absolute distance from that frame's instant
};

Place PlaceOf(TimeNs time, const Clock& clock,
              const std::vector<TrackFrame>& frames) {
  const size_t nearest = clock.NearestTo(time);
  const TimeNs from = time - clock.times[nearest];
  const int64_t count = std::llround(ToSeconds(from) * clock.rate_hz);
  const double at_s = static_cast<double>(count) / clock.rate_hz;
  return {frames[nearest].frame + count, std::abs(from - FromSeconds(at_s))};
}

class Pairer {
 public:
  Pairer(const TrackSequence& truth, const TrackSequence& tracks,
         const std::vector<FrameRange>& frames, const PairingNames& names)
      : truth_(truth), tracks_(tracks), frames_(frames), names_(names) {}

  FramePairing Pair() {
    truth_clock_ = ClockOf(truth_, names_.truth, &result_.notes);
    tracks_clock_ = ClockOf(tracks_, names_.tracks, &result_.notes);
    result_.truth_rate_hz = truth_clock_.rate_hz;
    result_.tracks_rate_hz = tracks_clock_.rate_hz;
    if (!truth_clock_.is_known() || !tracks_clock_.is_known()) {
      PairByNumber();
      NoteLengths();
      return std::move(result_);
    }
    same_rate_ =
        std::abs(truth_clock_.rate_hz - tracks_clock_.rate_hz) <=
        kSameRate * std::max(truth_clock_.rate_hz, tracks_clock_.rate_hz);
    const std::string both = truth_clock_.Text(names_.truth + " has") + ", " +
                             tracks_clock_.Text(names_.tracks);
    if (const std::optional<TimeNs> drift = DriftOfEqualNumbers()) {
      PairByNumber();
      result_.notes.push_back(fmt::format(
          "{}: frames of equal number have the same time at first and are "
          "{:.0f} ms apart in the end; frames are paired by number",
          both, 1e3 * ToSeconds(*drift)));
      return std::move(result_);
    }
    if (PairByTime()) {
      NoteTimes();
      return std::move(result_);
    }
    if (!same_rate_) {
      throw InputError(both +
                       ": no two frames have the same time, and frames are "
                       "not interpolated");
    }
    PairByNumber();
    result_.notes.push_back(
        both + ": they have no time in common, frames are paired by number");
    return std::move(result_);
  }

 private:
  void Add(int64_t frame, const TrackFrame* truth, const TrackFrame* tracks) {
    if (!ContainsFrame(frames_, frame)) return;
    result_.pairs.push_back({frame, truth, tracks});
    result_.truth_frames += truth != nullptr ? 1 : 0;
  }

  void PairByNumber() {
    auto found = tracks_.frames.begin();
    const auto end = tracks_.frames.end();
    for (const TrackFrame& expected : truth_.frames) {
      for (; found != end && found->frame < expected.frame; ++found) {
        Add(found->frame, nullptr, &*found);
      }
      const bool both = found != end && found->frame == expected.frame;
      Add(expected.frame, &expected, both ? &*found : nullptr);
      if (both) ++found;
    }
    for (; found != end; ++found) {
      Add(found->frame, nullptr, &*found);
    }
  }

  // Detects one rate that is written in two ways, as 30000/1001 and 30 Hz:
  // frames of equal number have the same time at first and, because of the two
  // rates, times more than half a frame apart at the end. Returns the final
  // difference; nullopt also where the times differ for another reason, such as
  // a pause that the numbers do not contain.
  std::optional<TimeNs> DriftOfEqualNumbers() const {
    if (!same_rate_) return std::nullopt;
    std::optional<TimeNs> first, last;
    int64_t from = 0;
    int64_t to = 0;
    auto found = tracks_.frames.begin();
    for (size_t i = 0; i < truth_.frames.size(); ++i) {
      const int64_t number = truth_.frames[i].frame;
      while (found != tracks_.frames.end() && found->frame < number) ++found;
      if (found == tracks_.frames.end()) break;
      if (found->frame != number) continue;
      const auto k = static_cast<size_t>(found - tracks_.frames.begin());
      last = std::abs(truth_clock_.times[i] - tracks_clock_.times[k]);
      to = number;
      if (first.has_value()) continue;
      first = last;
      from = number;
    }
    if (!last.has_value()) return std::nullopt;
    const double half_s = 0.5 / tracks_clock_.rate_hz;
    const double by_rates_s =
        static_cast<double>(to - from) *
        std::abs(1.0 / truth_clock_.rate_hz - 1.0 / tracks_clock_.rate_hz);
    const bool is_drift = ToSeconds(*first) <= half_s &&
                          ToSeconds(*last) > half_s &&
                          std::abs(ToSeconds(*last) - by_rates_s) <= half_s;
    return is_drift ? last : std::nullopt;
  }

  // Pairs frames one-to-one, those nearest in time first. False if no frames
  // coincide.
  bool PairByTime() {
    const TimeNs reach =
        same_rate_ ? FromSeconds(0.5 / tracks_clock_.rate_hz) : kSameInstant;
    std::vector<std::tuple<TimeNs, size_t, size_t>> near;  // gap, truth, tracks
    for (size_t i = 0; i < truth_.frames.size(); ++i) {
      const TimeNs time = truth_clock_.times[i];
      const size_t nearest = tracks_clock_.NearestTo(time);
      for (size_t k = nearest == 0 ? 0 : nearest - 1;
           k < std::min(nearest + 2, tracks_.frames.size()); ++k) {
        const TimeNs gap = std::abs(time - tracks_clock_.times[k]);
        if (gap <= reach) near.emplace_back(gap, i, k);
      }
    }
    if (near.empty()) return false;
    std::sort(near.begin(), near.end());
    std::vector<const TrackFrame*> of_truth(truth_.frames.size(), nullptr);
    std::vector<bool> is_taken(tracks_.frames.size(), false);
    TimeNs max_gap = 0;
    for (const auto& [gap, i, k] : near) {
      if (of_truth[i] != nullptr || is_taken[k]) continue;
      of_truth[i] = &tracks_.frames[k];
      is_taken[k] = true;
      max_gap = gap;
    }
    for (size_t i = 0; i < of_truth.size(); ++i) {
      const TrackFrame* expected = &truth_.frames[i];
      if (of_truth[i] != nullptr) {
        Add(of_truth[i]->frame, expected, of_truth[i]);
        continue;
      }
      const Place place =
          PlaceOf(truth_clock_.times[i], tracks_clock_, tracks_.frames);
      if (same_rate_ || place.off <= kSameInstant) {
        Add(place.frame, expected, nullptr);
      } else if (ContainsFrame(frames_, place.frame)) {
        ++result_.truth_between;
      }
    }
    for (size_t k = 0; k < is_taken.size(); ++k) {
      if (is_taken[k]) continue;
      const TrackFrame* found = &tracks_.frames[k];
      const Place place =
          PlaceOf(tracks_clock_.times[k], truth_clock_, truth_.frames);
      if (same_rate_ || place.off <= kSameInstant) {
        Add(found->frame, nullptr, found);
      }
    }
    std::stable_sort(result_.pairs.begin(), result_.pairs.end(),
                     [](const FramePair& a, const FramePair& b) {
                       return a.frame < b.frame;
                     });
    result_.is_by_time = true;
    result_.max_gap_s = ToSeconds(max_gap);
    return true;
  }

  void NoteTimes() {
    std::string note;
    if (!same_rate_) {
      note = fmt::format(
          "{} has {:.5g} Hz, {} {:.5g} Hz: {} of {} true frames are compared, "
          "those with the time of a frame of {}",
          names_.truth, truth_clock_.rate_hz, names_.tracks,
          tracks_clock_.rate_hz, result_.truth_frames,
          result_.truth_frames + result_.truth_between, names_.tracks);
      if (truth_.frames.front().frame == tracks_.frames.front().frame &&
          truth_.frames.back().frame == tracks_.frames.back().frame) {
        note += fmt::format(
            "; both have frames {} to {}: if these show the same instants, "
            "one of the rates is wrong",
            truth_.frames.front().frame, truth_.frames.back().frame);
      }
    } else {
      const auto other = std::find_if(
          result_.pairs.begin(), result_.pairs.end(), [](const FramePair& p) {
            return p.truth != nullptr && p.tracks != nullptr &&
                   p.truth->frame != p.tracks->frame;
          });
      if (other != result_.pairs.end()) {
        note = fmt::format("frame {} of {} has the time of frame {} of {}",
                           other->tracks->frame, names_.tracks,
                           other->truth->frame, names_.truth);
      }
      if (result_.max_gap_s * tracks_clock_.rate_hz > kRoundingFrames) {
        note += fmt::format(
            "{}the times of two paired frames differ by up to "
            "{:.0f} ms",
            note.empty() ? "" : ", and ", 1e3 * result_.max_gap_s);
      }
    }
    if (!note.empty()) {
      result_.notes.push_back("frames are paired by time: " + note);
    }
  }

  // Adds a note if equal frame numbers probably mean different times: both
  // recordings begin alike, but their lengths differ as at different rates.
  void NoteLengths() {
    if (!frames_.empty()) return;
    if (truth_.frames.empty() || tracks_.frames.empty()) return;
    const int64_t first = tracks_.frames.front().frame;
    if (std::abs(truth_.frames.front().frame - first) > 1) return;
    const auto length = [](const TrackSequence& recording) {
      return static_cast<double>(recording.frames.back().frame -
                                 recording.frames.front().frame + 1);
    };
    const double ratio = length(truth_) / length(tracks_);
    if (ratio < kLeastRatio && ratio > 1.0 / kLeastRatio) return;
    const bool of_truth = !truth_clock_.is_known();
    result_.notes.push_back(fmt::format(
        "no times of {}: frames are paired by number: {} has {:.0f} frames, "
        "{} {:.0f}; if both last equally long, the rates differ and the score "
        "is wrong",
        of_truth ? names_.truth : names_.tracks, names_.truth, length(truth_),
        names_.tracks, length(tracks_)));
  }

  const TrackSequence& truth_;
  const TrackSequence& tracks_;
  const std::vector<FrameRange>& frames_;
  const PairingNames& names_;
  Clock truth_clock_;
  Clock tracks_clock_;
  bool same_rate_ = true;
  FramePairing result_;
};

}  // namespace

FramePairing PairFrames(const TrackSequence& truth, const TrackSequence& tracks,
                        const std::vector<FrameRange>& frames,
                        const PairingNames& names) {
  return Pairer(truth, tracks, frames, names).Pair();
}

std::vector<std::string> NumberFramesLike(const TrackSequence& lead,
                                          const PairingNames& names,
                                          TrackSequence* recording) {
  FramePairing pairing = PairFrames(*recording, lead, {}, names);
  if (!pairing.is_by_time) return std::move(pairing.notes);
  std::vector<TrackFrame> frames;
  for (const FramePair& pair : pairing.pairs) {
    if (pair.truth == nullptr) continue;
    // Where the clock jitters by more than half a frame, two frames can have
    // the same number; the first is kept.
    if (!frames.empty() && frames.back().frame == pair.frame) continue;
    frames.push_back(*pair.truth);
    frames.back().frame = pair.frame;
  }
  recording->frames = std::move(frames);
  return std::move(pairing.notes);
}

}  // namespace kinegraph
